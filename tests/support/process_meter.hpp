// What this process costs, for benches.
#pragma once

#include <ctime>
#include <fstream>

#include <unistd.h>

namespace fusion_slam {

// Processor time of this process with its threads: others may be at work on the machine.
inline double process_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

inline double resident_mb() {  // 1e6 bytes
  std::ifstream statm("/proc/self/statm");
  double pages = 0.0, resident_pages = 0.0;
  statm >> pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) * 1e-6;
}

}  // namespace fusion_slam
