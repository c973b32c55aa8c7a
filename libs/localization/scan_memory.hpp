// All that the LiDAR saw on the latest way, in one piece: what a full-map search looks for. One
// scan alone fits many rooms; a few metres of way fit few.
#pragma once

#include <cstdint>
#include <deque>

#include "libs/geometry/pose.hpp"
#include "libs/localization/config.hpp"
#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

class ScanMemory {
 public:
  explicit ScanMemory(const LocalizerConfig& config) : config_(config) {}

  void add(std::int64_t utime_us, const SE2& T_odom_base, const Points& points_base);
  void clear() { scans_.clear(); }

  // In the base of the newest scan.
  Points points_base() const;
  std::size_t n_scans() const { return scans_.size(); }

 private:
  struct Scan {
    std::int64_t utime_us = 0;
    SE2 T_odom_base;
    Points points_base;
  };
  LocalizerConfig config_;
  std::deque<Scan> scans_;  // oldest first
};

}  // namespace fusion_slam
