// Two maps of one place become one: the second session is found in the first one's map, closures
// between them are made of the nodes that were found, one pose graph holds all, and the maps are
// composed anew.
#pragma once

#include <filesystem>

#include "libs/map_directory/manifest.hpp"

namespace fusion_slam {

struct MergeReport {
  MapSummary summary;               // of the joined map
  std::int64_t cross_loops = 0;     // closures between the two
  std::int64_t switched_off = 0;    // that the graph did not believe
  std::int64_t images_refused = 0;  // of another camera's size
  double shifted_s = 0.0;           // the second session's times were moved by this
};

// The result is in the first map's frame; `out` may be either of the two, which is then replaced in
// one step. Throws std::runtime_error, for people: a map is not whole, no overlap is proven, the
// two have different resolutions, out can't be written. The inputs are only read.
MergeReport merge_maps(const std::filesystem::path& first, const std::filesystem::path& second,
                       const std::filesystem::path& out);

}  // namespace fusion_slam
