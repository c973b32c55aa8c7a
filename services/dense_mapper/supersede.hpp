// Memory grows with the area, not with time: a voxel of an old submap that enough newer submaps
// know too says nothing any more (the clamped sum of equation 4 forgets it) and is dropped.
#pragma once

#include <cstdint>
#include <set>

#include "services/dense_mapper/dense_submap.hpp"

namespace fusion_slam {

// A submap closed: counts it as newer for every older closed submap that it overlaps. Returns the
// id of the one to be looked at by drop_superseded(): it has gathered `enough` of them (twice as
// many after each time it was looked at), was looked at least often, then gathered most. 0: none.
// Adds those that were counted to `counted`.
std::int64_t count_newer(std::int64_t closed_id, int enough, DenseSubmaps* submaps,
                         std::set<std::int64_t>* counted);

// While the submaps hold too much: the closed submap from which most is likely to go, of those that
// have gathered `enough` since they were looked at. That is the one with the largest product of its
// size and what it gathered, divided by one more than the times it was looked at. 0: none.
std::int64_t ripest(int enough, const DenseSubmaps& submaps);

// Drops from a closed submap the voxels that at least `keep` newer closed submaps know at the same
// place, and the points within them. True: nothing is left of it.
bool drop_superseded(std::int64_t id, int keep, double resolution_m, double cloud_resolution_m,
                     DenseSubmaps* submaps);

}  // namespace fusion_slam
