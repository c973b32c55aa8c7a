// Do the two sensors agree on how the robot moved from one keyframe to the next?
#pragma once

#include <optional>

#include "libs/geometry/pose.hpp"
#include "libs/graph/edge_noise.hpp"

namespace fusion_slam {

// How the LiDAR's trajectory says that the robot moved between two times.
struct LidarSays {
  SE3 T_from_to = SE3::Identity();
  // Of T_from_to in x, y, yaw; what the LiDAR itself says, without EdgeNoiseConfig's factors.
  Matrix6d covariance = Matrix6d::Identity();
};

// A visual edge that the LiDAR contradicts by more than gate_chi2 (squared, in units of both
// covariances as the graph believes them; 3 degrees of freedom: x, y, yaw): its covariance grown so
// far that the difference is one standard deviation of it, in all directions, for a wrong match is
// wrong in everything. The edge stays, so that nothing comes apart should the LiDAR be taken back.
// Nothing: the two agree. The LiDAR is believed, because its scans are matched whole and its
// covariance is wide along a corridor, where it may err; features agree by chance with a pose that
// isn't so and look certain then (docs/faults.md, "Soak").
std::optional<Matrix6d> doubted_covariance(const EdgeNoiseConfig& noise, const GraphEdge& visual,
                                           const LidarSays& lidar, bool planar, double gate_chi2);

}  // namespace fusion_slam
