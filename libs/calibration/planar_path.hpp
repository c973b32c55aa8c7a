// A planar motion known at some times, smooth between them.
#pragma once

#include <cstdint>
#include <vector>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

class PlanarPath {
 public:
  // Times must grow; others are ignored.
  void add(std::int64_t utime_us, const SE2& T_odom_body);

  std::size_t size() const { return times_us_.size(); }
  std::int64_t begin_us() const { return times_us_.front(); }  // size() > 0
  std::int64_t end_us() const { return times_us_.back(); }
  const std::vector<std::int64_t>& times_us() const { return times_us_; }

  // Between the two nearest poses a cubic whose velocities are those of the neighbours' difference
  // (Catmull-Rom, uneven times), x, y and the unwrapped yaw each for itself: right to the second
  // derivative. Beyond the ends, and where two poses lie more than `gap_us` apart: not known.
  bool knows(double utime_us) const;
  SE2 at(double utime_us) const;                    // knows(utime_us)
  Eigen::Vector3d velocity(double utime_us) const;  // of x, y, yaw in odom, 1/s
  static constexpr std::int64_t kGap_us = 500'000;

 private:
  std::size_t segment(double utime_us) const;
  Eigen::Vector3d slope(std::size_t i) const;
  Eigen::Vector3d cubic(double utime_us, bool derivative) const;

  std::vector<std::int64_t> times_us_;
  std::vector<Eigen::Vector3d> poses_;  // x, y, yaw without jumps
};

}  // namespace fusion_slam
