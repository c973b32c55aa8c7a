#include "tests/support/virtual_rplidar/world.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "libs/datasets/maebot.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

double clockwise_deg(double rad) {
  const double deg = std::fmod(-rad * 180.0 / M_PI, 360.0);
  return deg < 0.0 ? deg + 360.0 : deg;
}

// The turn begins where the turning part passes zero.
void rotate_to_zero(VirtualTurn* turn) {
  const auto smallest = std::min_element(
      turn->samples.begin(), turn->samples.end(),
      [](const VirtualSample& a, const VirtualSample& b) { return a.angle_deg < b.angle_deg; });
  std::rotate(turn->samples.begin(), smallest, turn->samples.end());
}

void add_lidar(const LogEvent& event, VirtualWorld* world) {
  bot_core::planar_lidar_t message;
  if (message.decode(event.data.data(), 0, static_cast<int>(event.data.size())) < 0) return;
  std::string why;
  const auto scan = from_message(message, &why);
  if (!scan || scan->ranges_m.size() < 8) return;
  VirtualTurn turn;
  turn.utime_us = scan->utime_us;
  for (std::size_t i = 0; i < scan->ranges_m.size(); ++i) {
    const double range_m = scan->ranges_m[i];
    const bool good = std::isfinite(range_m) && range_m > 0.0 && range_m < 16.0;
    const double angle_rad = scan->rad0 + static_cast<double>(i) * scan->radstep;
    turn.samples.push_back({clockwise_deg(angle_rad), good ? range_m : 0.0, good ? 47 : 0});
  }
  if (scan->radstep > 0.0) std::reverse(turn.samples.begin(), turn.samples.end());
  rotate_to_zero(&turn);
  world->turns.push_back(std::move(turn));
}

void add_sweeps(const MaebotLog& log, VirtualWorld* world) {
  for (const MaebotSweep& sweep : log.sweeps) {
    VirtualTurn turn;
    turn.utime_us = sweep.utime_us;
    for (std::size_t i = 0; i < sweep.ranges_m.size(); ++i)
      turn.samples.push_back(
          {clockwise_deg(-static_cast<double>(sweep.thetas_rad[i])),
           static_cast<double>(sweep.ranges_m[i]),
           std::clamp(static_cast<int>(std::lround(63.0 * sweep.intensities[i])), 0, 63)});
    world->turns.push_back(std::move(turn));
  }
}

double median_rate_hz(const VirtualWorld& world) {
  std::vector<double> periods_s;
  for (std::size_t i = 1; i < world.turns.size(); ++i)
    periods_s.push_back(1e-6 *
                        static_cast<double>(world.turns[i].utime_us - world.turns[i - 1].utime_us));
  if (periods_s.empty()) return 5.5;
  std::sort(periods_s.begin(), periods_s.end());
  return 1.0 / std::max(periods_s[periods_s.size() / 2], 0.02);
}

}  // namespace

VirtualWorld virtual_room(int n_turns, int n_samples) {
  VirtualWorld world;
  for (int t = 0; t < n_turns; ++t) {
    VirtualTurn turn;
    turn.utime_us = static_cast<std::int64_t>(1e6 * t / world.rate_hz);
    const double post_deg = 30.0 + std::fmod(15.0 * t, 300.0);  // never where a turn begins
    for (int i = 0; i < n_samples; ++i) {
      const double angle_deg = 360.0 * i / n_samples;
      const double x = std::cos(angle_deg * M_PI / 180.0);
      const double y = -std::sin(angle_deg * M_PI / 180.0);
      double range_m =
          std::min(2.0 / std::max(std::abs(x), 1e-9), 1.5 / std::max(std::abs(y), 1e-9));
      if (std::abs(std::remainder(angle_deg - post_deg, 360.0)) < 5.0) range_m = 0.8;
      if (angle_deg > 200.0 && angle_deg < 205.0) range_m = 0.0;  // a window
      turn.samples.push_back({angle_deg, range_m, range_m > 0.0 ? 47 : 0});
    }
    world.turns.push_back(std::move(turn));
  }
  return world;
}

VirtualWorld read_virtual_world(const std::filesystem::path& log) {
  VirtualWorld world;
  LogReader reader(log);
  LogEvent event;
  while (reader.next(&event))
    if (event.channel == "LIDAR") add_lidar(event, &world);
  if (world.turns.empty()) add_sweeps(read_maebot(log), &world);
  world.rate_hz = median_rate_hz(world);
  return world;
}

}  // namespace fusion_slam
