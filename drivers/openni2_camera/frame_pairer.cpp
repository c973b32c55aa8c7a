#include "drivers/openni2_camera/frame_pairer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace fusion_slam {
namespace {

// A stream that waits for the other one longer than this waits in vain: what is newest counts.
constexpr std::size_t kMostWaiting = 8;

}  // namespace

FramePairer::FramePairer(double period_s) : tolerance_us_(std::llround(0.5e6 * period_s)) {}

std::optional<FramePair> FramePairer::add_colour(TimedImage image) {
  if (image.utime_us <= last_colour_us_) return ++counters_.colour_alone, std::nullopt;
  last_colour_us_ = image.utime_us;
  colour_.push_back(std::move(image));
  return match();
}

std::optional<FramePair> FramePairer::add_depth(TimedImage image) {
  if (image.utime_us <= last_depth_us_) return ++counters_.depth_alone, std::nullopt;
  last_depth_us_ = image.utime_us;
  depth_.push_back(std::move(image));
  return match();
}

std::optional<FramePair> FramePairer::match() {
  while (!colour_.empty() && !depth_.empty()) {
    const std::int64_t error_us = depth_.front().utime_us - colour_.front().utime_us;
    if (std::abs(error_us) <= tolerance_us_) {
      FramePair pair{std::move(colour_.front()), std::move(depth_.front())};
      colour_.pop_front();
      depth_.pop_front();
      ++counters_.pairs;
      counters_.sum_error_us += static_cast<double>(std::abs(error_us));
      counters_.largest_error_us = std::max(counters_.largest_error_us, std::abs(error_us));
      return pair;
    }
    if (error_us > 0) {
      colour_.pop_front();
      ++counters_.colour_alone;
    } else {
      depth_.pop_front();
      ++counters_.depth_alone;
    }
  }
  if (colour_.size() > kMostWaiting) colour_.pop_front(), ++counters_.colour_alone;
  if (depth_.size() > kMostWaiting) depth_.pop_front(), ++counters_.depth_alone;
  return std::nullopt;
}

}  // namespace fusion_slam
