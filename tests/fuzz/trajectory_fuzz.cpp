// link: fs_datasets
// TUM trajectories: every pose is a rigid motion at a later time than the one before.
#include <cstdint>
#include <cstdlib>

#include "libs/datasets/trajectory_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto trajectory =
      fusion_slam::parse_tum_trajectory({reinterpret_cast<const char*>(data), size});
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) {
    const auto& pose = trajectory.poses[i];
    if (i > 0 && pose.utime_us <= trajectory.poses[i - 1].utime_us) std::abort();
    if (!pose.T_world_reference.matrix().allFinite()) std::abort();
  }
  return 0;
}
