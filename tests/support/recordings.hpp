// Finds the real recordings, which are not part of the repository.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

namespace fusion_slam {

// FUSION_SLAM_DATA, or ../shared/data beside the source tree.
inline std::filesystem::path recordings_root() {
  if (const char* root = std::getenv("FUSION_SLAM_DATA")) return root;
  return std::filesystem::path(FS_SOURCE_DIR) / ".." / "shared" / "data";
}

}  // namespace fusion_slam

// Declares `variable`; skips the test when that recording is missing, fails it under CI.
#define FS_RECORDING(variable, name)                                              \
  const std::filesystem::path variable = fusion_slam::recordings_root() / (name); \
  if (!std::filesystem::exists(variable)) {                                       \
    const char* ci = std::getenv("CI");                                           \
    if (ci != nullptr && std::string(ci) == "true")                               \
      FAIL() << "recording " << (name) << " not found";                           \
    GTEST_SKIP() << "skipped: recording " << (name) << " not found";              \
  }
