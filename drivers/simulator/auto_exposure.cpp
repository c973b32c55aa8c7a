#include "drivers/simulator/auto_exposure.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {
constexpr double kBlackGrey = 1.0;              // darker than this tells nothing more
constexpr std::size_t kRememberedFrames = 512;  // more than any number of threads is ahead
}  // namespace

AutoExposure::AutoExposure(const CameraNoise& noise, double frame_period_s)
    : noise_(noise),
      blend_(1.0 - std::exp(-frame_period_s / std::max(1e-6, noise.exposure_time_constant_s))) {}

double AutoExposure::wished(double mean_grey) const {
  return std::clamp(noise_.exposure_target / std::max(kBlackGrey, mean_grey), noise_.exposure_min,
                    noise_.exposure_max);
}

void AutoExposure::tell(std::int64_t index, std::optional<double> mean_grey) {
  if (!noise_.with_exposure) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  told_[index] = mean_grey;
  for (;;) {
    const std::int64_t next = after_.empty() ? 0 : after_.rbegin()->first + 1;
    const auto it = told_.find(next);
    if (it == told_.end()) break;
    double factor = 1.0;
    if (after_.empty()) {
      if (it->second) factor = wished(*it->second);
    } else {
      const double last = after_.rbegin()->second;
      // A share of the way on a logarithmic scale: stops of exposure.
      factor = it->second ? last * std::pow(wished(*it->second) / last, blend_) : last;
    }
    after_[next] = factor;
    told_.erase(it);
  }
  while (after_.size() > kRememberedFrames) after_.erase(after_.begin());
  changed_.notify_all();
}

double AutoExposure::factor(std::int64_t index) {
  if (!noise_.with_exposure) return noise_.exposure;
  const std::int64_t needed = std::max<std::int64_t>(0, index - kLateFrames);
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [&] { return cancelled_ || after_.count(needed) != 0; });
  return cancelled_ ? 1.0 : after_[needed];
}

void AutoExposure::cancel() {
  const std::lock_guard<std::mutex> lock(mutex_);
  cancelled_ = true;
  changed_.notify_all();
}

}  // namespace fusion_slam
