// CPU and memory of this machine and of processes, from /proc (proc(5)).
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include <sys/types.h>

namespace fusion_slam {

struct ProcessLoad {
  float cpu_usage = 0.0F;  // of the whole machine, 0 to 1, since the last sample
  std::int64_t vsize_bytes = 0;
  std::int64_t rss_bytes = 0;
};

struct MemoryState {
  std::int64_t total_bytes = 0;
  std::int64_t free_bytes = 0;  // available without swapping
  std::int64_t swap_total_bytes = 0;
  std::int64_t swap_free_bytes = 0;
};

MemoryState memory_state();

// Differences between calls of sample(). Not thread-safe.
class LoadMeter {
 public:
  // Reads the machine's counters; what follows is counted against them.
  void sample();
  float cpu_load() const { return cpu_load_; }  // 0 to 1

  // Nothing when there is no such process. A process's first sample says no CPU usage.
  std::optional<ProcessLoad> process(pid_t pid);
  void forget(pid_t pid) { ticks_.erase(pid); }

 private:
  std::int64_t busy_ = 0;   // ticks since boot
  std::int64_t total_ = 0;  // busy and idle, all cores
  std::int64_t elapsed_ = 0;
  float cpu_load_ = 0.0F;
  std::map<pid_t, std::int64_t> ticks_;
};

}  // namespace fusion_slam
