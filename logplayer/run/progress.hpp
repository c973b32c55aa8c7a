// The progress of a run for people: a bar, and each process's latency and queue.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>

#include "fusion_slam/status_t.hpp"

namespace fusion_slam {

class Progress {
 public:
  Progress();

  // Redraws at most 5 times a second on a terminal, else prints a line every 10 s; `last` always.
  void show(double fraction, double log_s, const std::map<std::string, status_t>& processes,
            bool last = false);
  void finish();  // leaves the cursor below

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_;
  Clock::time_point started_;
  Clock::time_point last_;
  std::size_t lines_drawn_ = 0;
};

}  // namespace fusion_slam
