#include "services/lidar_mapper/scan_clock.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

namespace fusion_slam {
namespace {

constexpr std::size_t kRemembered = 15;
constexpr std::size_t kEnough = 5;
constexpr std::size_t kStamps = 64;        // that a line is fitted to
constexpr std::size_t kEnoughStamps = 24;  // before that the stamps stand as they are
constexpr int kScansBetweenSearches = 32;
constexpr double kLongestGap = 20.0;  // periods; after that turns can't be counted
// Stamps that lie anywhere in the period leave a rest of 0.29 periods and no coherence.
constexpr double kMostRest = 0.22;
constexpr double kLeastCoherence = 0.35;

// How well the stamps agree on a phase of this period (0 ... 1), and that phase, s.
double coherence(const std::deque<double>& stamps_s, double period_s, double* phase_s = nullptr) {
  std::complex<double> sum;
  for (const double s : stamps_s) sum += std::polar(1.0, 2.0 * M_PI * s / period_s);
  if (phase_s != nullptr) *phase_s = std::arg(sum) / (2.0 * M_PI) * period_s;
  return std::abs(sum) / static_cast<double>(stamps_s.size());
}

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

void ScanClock::find_period() {
  since_search_ = 0;
  const double middle = period_s();
  // Neighbouring periods drift apart by a fifth of a turn over the window.
  const double step =
      0.2 * middle * middle / std::max(stamps_s_.back() - stamps_s_.front(), middle);
  double best = 0.0;
  turning_s_ = 0.0;
  const int steps = static_cast<int>(0.5 * middle / step);
  for (int i = 0; i <= steps; ++i) {
    const double period = 0.75 * middle + i * step;
    const double c = coherence(stamps_s_, period);
    if (c > best) best = c, turning_s_ = period;
  }
  if (best < kLeastCoherence) turning_s_ = 0.0;
}

// The time of the newest stamp's turn by a line through the recent stamps; the stamp itself when no
// even turning is seen.
double ScanClock::even_time(double stamp_s) {
  locked_ = false;
  if (stamps_s_.size() < kEnoughStamps) return stamp_s;
  if (turning_s_ == 0.0 || ++since_search_ >= kScansBetweenSearches) find_period();
  if (turning_s_ == 0.0) return stamp_s;
  double phase_s = 0.0;
  if (coherence(stamps_s_, turning_s_, &phase_s) < kLeastCoherence) {
    turning_s_ = 0.0;
    return stamp_s;
  }
  const double n = static_cast<double>(stamps_s_.size());
  double k_mean = 0.0, s_mean = 0.0;
  std::vector<double> turns;
  for (const double s : stamps_s_) {
    turns.push_back(std::round((s - phase_s) / turning_s_));
    k_mean += turns.back() / n, s_mean += s / n;
  }
  double kk = 0.0, ks = 0.0;
  for (std::size_t i = 0; i < turns.size(); ++i) {
    kk += (turns[i] - k_mean) * (turns[i] - k_mean);
    ks += (turns[i] - k_mean) * (stamps_s_[i] - s_mean);
  }
  if (!(kk > 0.0)) return stamp_s;
  const double slope = ks / kk;
  double rest = 0.0;
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const double e = stamps_s_[i] - s_mean - slope * (turns[i] - k_mean);
    rest += e * e / n;
  }
  if (std::sqrt(rest) > kMostRest * turning_s_) return stamp_s;
  locked_ = true;
  turning_s_ = slope;
  const double even = s_mean + slope * (turns.back() - k_mean);
  return std::clamp(even, stamp_s - 0.5 * slope, stamp_s + 0.5 * slope);
}

ScanClock::Interval ScanClock::advance(std::int64_t utime_us) {
  const double raw_s = started_ ? static_cast<double>(utime_us - last_us_) * 1e-6 : 0.0;
  const bool first = !started_;
  started_ = true;
  last_us_ = utime_us;
  const double period = period_s();
  if (raw_s > 1e-4) {
    recent_s_.push_back(raw_s);
    if (recent_s_.size() > kRemembered) recent_s_.pop_front();
  }
  if (first || raw_s < -period || raw_s > kLongestGap * period) {  // turns can't be counted
    first_us_ = utime_us;
    stamps_s_.clear();
    turning_s_ = 0.0;
    last_even_s_ = -raw_s;
  }
  const double stamp_s = static_cast<double>(utime_us - first_us_) * 1e-6;
  stamps_s_.push_back(stamp_s);
  if (stamps_s_.size() > kStamps) stamps_s_.pop_front();
  // A sensor doesn't sweep five times as fast as it usually does: such stamps are jitter or
  // repeats.
  const bool trusted = !first && raw_s > 0.2 * period;
  double even_s = even_time(stamp_s);
  double dt_s = first ? period : even_s - last_even_s_;
  if (!first && locked_ && dt_s < 0.5 * turning_s_) {  // two scans in one turn can't be: the next
    dt_s = turning_s_;
    even_s = std::min(last_even_s_ + turning_s_, stamp_s + 0.5 * turning_s_);
  } else if (!locked_) {
    dt_s = trusted ? raw_s : period;
  }
  last_even_s_ = even_s;
  return {dt_s, trusted, locked_ ? stamp_s - even_s : 0.0};
}

}  // namespace fusion_slam
