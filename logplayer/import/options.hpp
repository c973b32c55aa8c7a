// What the person asked for on the command line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace fusion_slam {

struct ImportOptions {
  std::string format;  // tum, 7scenes, carmen, rplidar-lcm, hokuyo
  std::filesystem::path source;
  std::filesystem::path output;
  bool no_odometry = false;
  std::filesystem::path robot_file;        // empty: the format's own of config/robots
  std::optional<std::int64_t> max_frames;  // camera frames or scans
  std::int64_t start = 0;                  // frames or scans left out at the beginning
  std::filesystem::path
      ground_truth;  // TUM trajectory of the reference frame; empty: the recording's own
  bool corrected_as_ground_truth = false;
};

// The options, or nothing when the program is to end with *exit_code (--help: 0, wrong usage: 2).
std::optional<ImportOptions> parse_options(int argc, char** argv, int* exit_code);

}  // namespace fusion_slam
