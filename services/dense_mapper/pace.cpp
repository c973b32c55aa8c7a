#include "services/dense_mapper/pace.hpp"

namespace fusion_slam {

void Pace::followed(double now_s, double cost_s, std::size_t queue) {
  next_s_ = now_s + (behind(queue) ? 15.0 : 3.0) * cost_s;
}

bool Pace::maps_next(std::size_t queue) {
  std::int64_t every = 1;
  for (std::size_t limit = kBehind; queue > limit && every < 64; limit *= 2) every *= 2;
  if (++since_mapped_ < every) return false;
  since_mapped_ = 0;
  return true;
}

}  // namespace fusion_slam
