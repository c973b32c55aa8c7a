#include "services/dense_mapper/pace.hpp"

#include <algorithm>

namespace fusion_slam {

namespace {

constexpr double kStepS = 0.1;
constexpr std::size_t kFewestCubes = 4;
constexpr std::size_t kMostCubes = 4096;

}  // namespace

void Pace::followed(double now_s, double cost_s, std::size_t cubes, std::size_t queue) {
  next_s_ = now_s + (behind(queue) ? 15.0 : 3.0) * cost_s;
  if (cost_s > kStepS)
    cubes_a_step_ = std::max(kFewestCubes, cubes_a_step_ / 2);
  else if (cost_s < kStepS / 2 && cubes >= cubes_a_step_)
    cubes_a_step_ = std::min(kMostCubes, cubes_a_step_ * 2);
}

bool Pace::maps_next(std::size_t queue) {
  std::int64_t every = 1;
  for (std::size_t limit = kBehind; queue > limit && every < 64; limit *= 2) every *= 2;
  if (++since_mapped_ < every) return false;
  since_mapped_ = 0;
  return true;
}

}  // namespace fusion_slam
