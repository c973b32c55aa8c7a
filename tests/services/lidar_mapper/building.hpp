// A drawn office building of two long corridors that two short ones join, rooms along them, doors,
// furniture; a robot's way through it; and scanners to drive there. For measuring drift and whether
// covariances mean what they say: everything is exact and seeded.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "tests/services/lidar_mapper/flat_world.hpp"

namespace fusion_slam {

// Corridors are 2.2 m wide, the whole is `length_m` x 32 m. A `bare` building has neither rooms nor
// doors: corridors only, which scans do not fix lengthwise.
inline FlatWorld office_building(unsigned seed, double length_m, bool bare = false) {
  std::mt19937 rng(seed);
  const auto uniform = [&rng](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(rng);
  };
  FlatWorld world;
  world.walls.clear();
  const auto line = [&world](double x0, double y0, double x1, double y1) {
    world.walls.push_back({{x0, y0}, {x1, y1}});
  };
  const auto box = [&](double x, double y, double w, double h, double yaw) {
    const SE2 T{x, y, yaw};
    const Eigen::Vector2d c[4] = {T * Eigen::Vector2d(-w, -h), T * Eigen::Vector2d(w, -h),
                                  T * Eigen::Vector2d(w, h), T * Eigen::Vector2d(-w, h)};
    for (int i = 0; i < 4; ++i) world.walls.push_back({c[i], c[(i + 1) % 4]});
  };
  // One wall along x at `y` with rooms behind it on the side `out`; doors open now and then.
  const auto row = [&](double y, double out, double depth) {
    double x = 2.2;
    const double end = length_m - 2.2;
    while (x < end) {
      const double next = bare ? end : std::min(end, x + uniform(3.0, 6.0));
      const double width = next - x;
      if (bare || width < 2.0) {
        line(x, y, next, y);
      } else {
        const double a = x + uniform(0.3, width - 1.3), b = a + 0.9, back = y + out * depth;
        line(x, y, a, y);
        line(b, y, next, y);
        line(a, y, a, y + 0.15 * out);
        line(b, y, b, y + 0.15 * out);
        const bool closed = uniform(0.0, 1.0) < 0.5;
        if (closed) {
          line(a, y + 0.12 * out, b, y + 0.12 * out);
        } else {
          line(x, y + 0.15 * out, a, y + 0.15 * out);
          line(b, y + 0.15 * out, next, y + 0.15 * out);
          line(x, y, x, back);
          line(next, y, next, back);
          line(x, back, next, back);
          for (int i = 0; i < 3; ++i)
            box(uniform(x + 0.6, next - 0.6), y + out * uniform(1.5, depth - 0.6),
                uniform(0.1, 0.5), uniform(0.1, 0.4), uniform(-M_PI, M_PI));
        }
      }
      x = next;
    }
  };
  const double w = 2.2, top = 16.0;
  line(0, 0, length_m, 0);  // outer walls of the ring, with rooms below and above
  line(0, top + w, length_m, top + w);
  line(0, 0, 0, top + w);
  line(length_m, 0, length_m, top + w);
  row(w, 1.0, 6.5);
  row(top, -1.0, 6.5);
  line(w, w, w, top);
  line(length_m - w, w, length_m - w, top);
  if (!bare)
    for (int i = 0; i < static_cast<int>(length_m / 6.0); ++i) {  // pillars, cabinets
      const double x = uniform(3.0, length_m - 3.0);
      if (i % 2 == 0)
        box(x, uniform(0.05, 0.15), uniform(0.1, 0.6), 0.15, 0.0);
      else
        box(x, top + w - uniform(0.05, 0.15), uniform(0.1, 0.6), 0.15, 0.0);
    }
  return world;
}

// Poses by time along a polyline at 0.5 m/s, turning on the spot at its corners with 0.6 rad/s.
class Way {
 public:
  explicit Way(const std::vector<Eigen::Vector2d>& corners, double speed = 0.5, double turn = 0.6) {
    double t = 0.0, yaw = 0.0;
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
      const Eigen::Vector2d d = corners[i + 1] - corners[i];
      const double heading = std::atan2(d.y(), d.x());
      const double by = i == 0 ? 0.0 : wrap_angle(heading - yaw);
      yaw = i == 0 ? heading : yaw;
      legs_.push_back({t, corners[i], d.normalized(), 0.0, yaw, by, std::abs(by) / turn});
      t += std::abs(by) / turn;
      yaw = wrap_angle(yaw + by);
      legs_.push_back({t, corners[i], d.normalized(), d.norm(), yaw, 0.0, d.norm() / speed});
      t += d.norm() / speed;
    }
    duration_s_ = t;
  }

  double duration_s() const { return duration_s_; }

  SE2 operator()(double t) const {
    t = std::clamp(t, 0.0, duration_s_);
    auto leg = std::upper_bound(legs_.begin(), legs_.end(), t,
                                [](double at, const Leg& l) { return at < l.start_s; });
    --leg;
    // Smooth start and end of each leg: speed 0 at both.
    const double u =
        leg->lasts_s > 0.0 ? std::clamp((t - leg->start_s) / leg->lasts_s, 0.0, 1.0) : 1.0;
    const double ramp = std::min(0.5, leg->lasts_s > 0.0 ? 1.0 / leg->lasts_s : 0.5);  // 1 s
    const double v = 1.0 / (1.0 - ramp);
    double s = 0.0;
    if (u < ramp)
      s = 0.5 * v * u * u / ramp;
    else if (u <= 1.0 - ramp)
      s = v * (u - 0.5 * ramp);
    else
      s = 1.0 - 0.5 * v * (1.0 - u) * (1.0 - u) / ramp;
    const Eigen::Vector2d p = leg->from + s * leg->length_m * leg->along;
    // A robot never drives dead straight.
    const double sway =
        leg->length_m > 2.0
            ? 0.12 * std::sin(2.0 * M_PI * s * leg->length_m / 5.0) * std::sin(M_PI * s)
            : 0.0;
    const Eigen::Vector2d q = p + sway * Eigen::Vector2d(-leg->along.y(), leg->along.x());
    return {q.x(), q.y(), wrap_angle(leg->yaw + s * leg->turn + 0.6 * sway)};
  }

 private:
  struct Leg {
    double start_s;
    Eigen::Vector2d from, along;
    double length_m, yaw, turn, lasts_s;
  };
  std::vector<Leg> legs_;
  double duration_s_ = 0.0;
};

// Once around the ring and half a round more.
inline Way round_of(double length_m) {
  const double e = length_m - 1.1;
  return Way({{1.1, 1.1}, {e, 1.1}, {e, 17.1}, {1.1, 17.1}, {1.1, 1.1}, {e, 1.1}, {e, 9.0}});
}

struct Scanner {
  const char* name;
  LidarModel model;
  double fov_rad;
  int beams;
  double step_m;  // of the readings
};

inline std::vector<Scanner> scanners() {
  return {{"sick", {0.05, 80.0, 0.012, 4.7, 0.0}, M_PI, 181, 0.01},
          {"sick-half", {0.05, 80.0, 0.012, 4.7, 0.0}, M_PI, 361, 0.01},
          {"rplidar", {0.15, 12.0, 0.02, 5.5, 0.0005}, 2.0 * M_PI, 360, 0.0005},
          {"hokuyo", {0.06, 4.0, 0.015, 10.0, 0.0000976}, 4.19, 683, 0.001},
          {"utm", {0.1, 30.0, 0.015, 40.0, 0.0000231}, 4.71, 1081, 0.001}};
}

// One sweep as the scanner gives it: noise, steps of the readings, nothing beyond its range.
template <class Path>
LaserScan scanner_sweep(const FlatWorld& world, const Scanner& scanner, const SE3& T_base_lidar,
                        const Path& path, double t, std::mt19937& rng) {
  std::normal_distribution<double> noise(0.0, scanner.model.sigma_m);
  LaserScan scan;
  scan.utime_us = static_cast<std::int64_t>(std::llround(t * 1e6)) + 1'000'000;
  const bool round = scanner.fov_rad > 6.0;
  scan.rad0 = -0.5 * scanner.fov_rad;
  scan.radstep = scanner.fov_rad / (round ? scanner.beams : scanner.beams - 1);
  for (int i = 0; i < scanner.beams; ++i) {
    const SE3 T = to_se3(path(t + i * scanner.model.beam_period_s)) * T_base_lidar;
    const double angle = scan.rad0 + i * scan.radstep;
    const Eigen::Vector3d d = T.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
    double r = world.range(T.translation().head<2>(), std::atan2(d.y(), d.x()));
    r += noise(rng);
    r = std::round(r / scanner.step_m) * scanner.step_m;
    scan.ranges_m.push_back(static_cast<float>(r < scanner.model.range_max_m ? r : 1e3));
  }
  return scan;
}

}  // namespace fusion_slam
