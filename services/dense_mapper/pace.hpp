// How a dense mapper that can't keep up gives way, live only: anchors that moved are followed less
// often, and images of places that the map knows already are left out. Clock and queue are the
// caller's. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fusion_slam {

class Pace {
 public:
  // So many cubes of the map were composed again: now_s, after it took cost_s, with `queue`
  // messages waiting. At most a quarter of the time goes into this, a sixteenth while it is behind.
  void followed(double now_s, double cost_s, std::size_t cubes, std::size_t queue);
  bool may_follow(double now_s) const { return now_s >= next_s_; }
  // So many take about a tenth of a second, as far as known: what comes meanwhile waits no longer.
  std::size_t cubes_a_step() const { return cubes_a_step_; }

  // More messages wait than a few seconds bring.
  static bool behind(std::size_t queue) { return queue > kBehind; }
  // Whether the n-th submap that begins where the map knows the place is to be mapped: every one,
  // every second, fourth, eighth ... the longer the queue is.
  bool maps_next(std::size_t queue);

 private:
  static constexpr std::size_t kBehind = 64;  // GRAPH and images: about 5 s
  double next_s_ = 0.0;
  std::size_t cubes_a_step_ = 16;
  std::int64_t since_mapped_ = 0;  // submaps left out
};

}  // namespace fusion_slam
