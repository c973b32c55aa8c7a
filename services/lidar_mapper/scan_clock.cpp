#include "services/lidar_mapper/scan_clock.hpp"

#include <algorithm>
#include <vector>

namespace fusion_slam {
namespace {

constexpr std::size_t kRemembered = 15;
constexpr std::size_t kEnough = 5;

}  // namespace

ScanClock::ScanClock(double nominal_rate_hz)
    : nominal_s_(nominal_rate_hz >= 0.5 && nominal_rate_hz <= 200.0 ? 1.0 / nominal_rate_hz : 0.1) {
}

double ScanClock::period_s() const {
  if (recent_s_.size() < kEnough) return nominal_s_;
  std::vector<double> sorted(recent_s_.begin(), recent_s_.end());
  std::sort(sorted.begin(), sorted.end());
  return sorted[sorted.size() / 2];
}

ScanClock::Interval ScanClock::advance(std::int64_t utime_us) {
  const double raw_s = started_ ? static_cast<double>(utime_us - last_us_) * 1e-6 : 0.0;
  const bool first = !started_;
  started_ = true;
  last_us_ = utime_us;
  const double period = period_s();
  // A sensor doesn't sweep five times as fast as it usually does: such stamps are jitter or
  // repeats.
  const bool trusted = !first && raw_s > 0.2 * period;
  if (raw_s > 1e-4) {
    recent_s_.push_back(raw_s);
    if (recent_s_.size() > kRemembered) recent_s_.pop_front();
  }
  return {trusted ? raw_s : period, trusted};
}

}  // namespace fusion_slam
