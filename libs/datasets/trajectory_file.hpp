// TUM trajectory files: "seconds tx ty tz qx qy qz qw" a line, # comments.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "libs/datasets/text.hpp"
#include "libs/geometry/pose.hpp"

namespace fusion_slam {

struct ReferencePose {
  std::int64_t utime_us = 0;
  SE3 T_world_reference = SE3::Identity();
};

struct ReferenceTrajectory {
  std::vector<ReferencePose> poses;  // utime strictly increasing
  Skipped skipped;                   // by line
};

ReferenceTrajectory parse_tum_trajectory(std::string_view text);
// Throws DatasetError when the file cannot be read or holds no pose.
ReferenceTrajectory read_tum_trajectory(const std::filesystem::path& path);

}  // namespace fusion_slam
