#include "libs/datasets/trajectory_file.hpp"

#include <algorithm>
#include <array>

namespace fusion_slam {
namespace {

// Position and quaternion (x, y, z, w) of a line's rest, or the reason why not.
std::optional<SE3> parse_pose(std::string_view rest, std::string* why) {
  std::array<double, 7> v{};
  for (double& value : v) {
    const auto number = parse_number(next_word(&rest));
    if (!number) return *why = "fewer than 8 numbers", std::nullopt;
    value = *number;
  }
  const double norm = v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6];
  if (norm < 0.5 || norm > 2.0) return *why = "quaternion is not a rotation", std::nullopt;
  return make_pose({v[0], v[1], v[2]}, v[6], v[3], v[4], v[5]);
}

}  // namespace

ReferenceTrajectory parse_tum_trajectory(std::string_view text) {
  ReferenceTrajectory trajectory;
  std::int64_t line_number = 0;
  std::string_view line;
  while (next_line(&text, &line)) {
    ++line_number;
    const std::string_view stamp = next_word(&line);
    if (stamp.empty() || stamp.front() == '#') continue;
    const auto utime_us = parse_seconds_us(stamp);
    std::string why = "time stamp is not a number";
    const auto pose = utime_us ? parse_pose(line, &why) : std::nullopt;
    if (!pose) {
      trajectory.skipped.add(line_number, why);
    } else if (!trajectory.poses.empty() && *utime_us <= trajectory.poses.back().utime_us) {
      trajectory.skipped.add(line_number, "time stamp does not increase");
    } else {
      trajectory.poses.push_back({*utime_us, *pose});
    }
  }
  return trajectory;
}

ReferenceTrajectory read_tum_trajectory(const std::filesystem::path& path) {
  ReferenceTrajectory trajectory = parse_tum_trajectory(read_text_file(path));
  if (trajectory.poses.empty())
    throw DatasetError(path.string() +
                       ": no line \"seconds tx ty tz qx qy qz qw\"; is this a TUM trajectory?");
  return trajectory;
}

}  // namespace fusion_slam
