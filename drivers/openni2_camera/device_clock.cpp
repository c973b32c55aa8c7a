#include "drivers/openni2_camera/device_clock.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace fusion_slam {
namespace {

constexpr double kWindow_us = 1e6;
constexpr std::size_t kWindows = 60;
// A drift of 100 ppm is 1 ms in 10 s, above the jitter of arrivals: from then on it is worth more
// than it costs.
constexpr double kSpan_us = 10e6;
constexpr double kMostDrift = 500e-6;  // crystals: 100 ppm each
constexpr double kBack_us = 0.5e6;     // a stamp that much older: the clock began anew
constexpr double kJump_us = 50e3;      // earlier than any drift allows: it jumped ahead
constexpr int kLateWindows = 3;        // in a row, all late by kJump_us: it jumped back a little

}  // namespace

void DeviceClock::restart(std::int64_t device_us, std::int64_t host_us) {
  if (started_) ++restarts_;
  started_ = true;
  origin_us_ = device_us;
  base_us_ = host_us - device_us;
  last_us_ = window_begin_us_ = slope_ = offset_us_ = 0.0;
  late_windows_ = 0;
  lowest_.assign(1, {0.0, 0.0});
}

std::int64_t DeviceClock::add(std::int64_t device_us, std::int64_t host_us) {
  if (device_us == 0) return host_us;
  if (!started_) restart(device_us, host_us);
  double x = static_cast<double>(device_us - origin_us_);
  double y = static_cast<double>(host_us - device_us - base_us_);
  if (x < last_us_ - kBack_us || y < line(x) - kJump_us) {
    restart(device_us, host_us);
    x = y = 0.0;
  }
  last_us_ = std::max(last_us_, x);
  if (x > window_begin_us_ + kWindow_us) {
    const Point& closed = lowest_.back();
    late_windows_ = closed.y_us > line(closed.x_us) + kJump_us ? late_windows_ + 1 : 0;
    if (late_windows_ >= kLateWindows) {
      restart(device_us, host_us);
      return host_us;
    }
    window_begin_us_ = x;
    lowest_.push_back({x, y});
    if (lowest_.size() > kWindows) lowest_.pop_front();
    fit();
  } else if (y < lowest_.back().y_us) {
    lowest_.back() = {x, y};
    fit();
  }
  const double late_us = std::max(0.0, y - line(x));
  return host_us - std::llround(late_us);
}

void DeviceClock::fit() {
  std::vector<Point> hull;
  for (const Point& p : lowest_) {
    while (hull.size() >= 2) {
      const Point& a = hull[hull.size() - 2];
      const Point& b = hull.back();
      if ((b.x_us - a.x_us) * (p.y_us - a.y_us) > (b.y_us - a.y_us) * (p.x_us - a.x_us)) break;
      hull.pop_back();
    }
    hull.push_back(p);
  }
  slope_ = 0.0;
  if (lowest_.back().x_us - lowest_.front().x_us > kSpan_us) {
    double middle_us = 0.0;
    for (const Point& p : lowest_) middle_us += p.x_us / static_cast<double>(lowest_.size());
    for (std::size_t i = 0; i + 1 < hull.size(); ++i)
      if (hull[i + 1].x_us >= middle_us) {
        slope_ = (hull[i + 1].y_us - hull[i].y_us) / (hull[i + 1].x_us - hull[i].x_us);
        break;
      }
    slope_ = std::clamp(slope_, -kMostDrift, kMostDrift);
  }
  offset_us_ = lowest_.front().y_us - slope_ * lowest_.front().x_us;
  for (const Point& p : lowest_) offset_us_ = std::min(offset_us_, p.y_us - slope_ * p.x_us);
}

}  // namespace fusion_slam
