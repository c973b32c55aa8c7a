// Trajectory files of the TUM RGB-D benchmark (Sturm et al. 2012): one pose a line,
//   time x y z qx qy qz qw
// time in s, position in m, unit quaternion with w LAST. Lines that start with # are comments.
#pragma once

#include <cstddef>
#include <filesystem>
#include <istream>
#include <ostream>
#include <string>

#include "libs/evaluation/number_rows.hpp"
#include "libs/evaluation/trajectory.hpp"

namespace fusion_slam {

struct TumFile {
  Trajectory trajectory;         // ordered by time (stable), quaternions normalised
  std::size_t out_of_order = 0;  // lines whose time was less than that of the line before
  std::size_t repeated = 0;      // poses whose time equals that of the pose before (they are kept)
};

// Strict: throws FileError (number_rows.hpp) with file, line and reason, also for a quaternion
// whose norm is off by more than 1 % (swapped or missing columns) and for a file without poses.
TumFile read_tum(const std::filesystem::path& file);
TumFile read_tum(std::istream& in, const std::string& name);

// Times with 6 decimals (a utime survives exactly), positions and quaternions with 9, w >= 0.
// The path version writes a neighbour file and renames it, so that a reader never sees half a file;
// throws FileError when that fails. `comment` (one line, may be empty) becomes the first line.
void write_tum(const std::filesystem::path& file, const Trajectory& trajectory,
               const std::string& comment = "timestamp tx ty tz qx qy qz qw");
void write_tum(std::ostream& out, const Trajectory& trajectory, const std::string& comment);

}  // namespace fusion_slam
