#include "drivers/rplidar/resample.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

// Two neighbours are of one surface when they differ by less than on a wall seen at 75 degrees from
// its normal.
const double kSteepest = std::tan(75.0 * M_PI / 180.0);

bool one_surface(const Measurement& a, const Measurement& b, double gap_deg) {
  if (a.range_m <= 0.0 || b.range_m <= 0.0) return false;
  const double most_m = gap_deg * M_PI / 180.0 * kSteepest * std::min(a.range_m, b.range_m);
  return std::abs(a.range_m - b.range_m) < most_m;
}

}  // namespace

LaserScan to_laser_scan(const Revolution& revolution, double beam_period_s) {
  std::vector<Measurement> by_angle = revolution.measurements;
  std::stable_sort(
      by_angle.begin(), by_angle.end(),
      [](const Measurement& a, const Measurement& b) { return a.angle_deg < b.angle_deg; });
  const double wanted = std::round(revolution.period_s / beam_period_s);
  const auto n = static_cast<std::size_t>(
      std::clamp(wanted, static_cast<double>(kFewestBeams), static_cast<double>(kMostBeams)));
  const double step_deg = 360.0 / static_cast<double>(n);
  const double spacing_deg = 360.0 / static_cast<double>(by_angle.size());
  const double reach_deg = 1.5 * std::max(step_deg, spacing_deg);

  LaserScan scan;
  scan.utime_us = revolution.measurements.front().utime_us;
  scan.rad0 = 0.0;
  scan.radstep = -2.0 * M_PI / static_cast<double>(n);
  scan.ranges_m.assign(n, 0.0F);
  if (revolution.has_quality) scan.intensities.assign(n, 0.0F);
  std::size_t next = 0;  // the first one beyond the beam
  for (std::size_t i = 0; i < n; ++i) {
    const double beam_deg = static_cast<double>(i) * step_deg;
    while (next < by_angle.size() && by_angle[next].angle_deg <= beam_deg) ++next;
    const bool wraps_before = next == 0;
    const bool wraps_after = next == by_angle.size();
    const Measurement& a = wraps_before ? by_angle.back() : by_angle[next - 1];
    const Measurement& b = wraps_after ? by_angle.front() : by_angle[next];
    const double before_deg = beam_deg - a.angle_deg + (wraps_before ? 360.0 : 0.0);
    const double after_deg = b.angle_deg - beam_deg + (wraps_after ? 360.0 : 0.0);
    const double gap_deg = before_deg + after_deg;
    if (std::min(before_deg, after_deg) > reach_deg) continue;
    const Measurement& nearest = after_deg < before_deg ? b : a;
    const bool between = gap_deg > 0.0 && gap_deg <= 2.0 * reach_deg && one_surface(a, b, gap_deg);
    scan.ranges_m[i] = static_cast<float>(
        between ? (a.range_m * after_deg + b.range_m * before_deg) / gap_deg : nearest.range_m);
    if (revolution.has_quality) scan.intensities[i] = static_cast<float>(nearest.quality);
  }
  return scan;
}

}  // namespace fusion_slam
