// The text format of the Mines ParisTech recordings (tinySLAM, BreezySLAM): one sweep of a Hokuyo
// URG-04LX and the wheel encoders a line, integers: 0 time (us), 2 and 3 left and right encoder
// (ticks), 24... ranges (mm).
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "libs/datasets/text.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

struct HokuyoRecord {
  std::int64_t line = 0;
  LaserScan scan;  // counter-clockwise, from -119.5 to +119.9 degrees
  std::int64_t left_ticks = 0;
  std::int64_t right_ticks = 0;
};

struct HokuyoLog {
  std::vector<HokuyoRecord> records;  // utime strictly increasing
  std::int64_t lines = 0;
  Skipped skipped;  // by line
};

HokuyoLog parse_mines_hokuyo(std::string_view text);
// Throws DatasetError when the file cannot be read or holds no usable line.
HokuyoLog read_mines_hokuyo(const std::filesystem::path& path);

}  // namespace fusion_slam
