#include "libs/process/load.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

#include <unistd.h>

namespace fusion_slam {

MemoryState memory_state() {
  MemoryState state;
  std::ifstream file("/proc/meminfo");
  const std::map<std::string, std::int64_t*> wanted{{"MemTotal:", &state.total_bytes},
                                                    {"MemAvailable:", &state.free_bytes},
                                                    {"SwapTotal:", &state.swap_total_bytes},
                                                    {"SwapFree:", &state.swap_free_bytes}};
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string name;
    std::int64_t kilobytes = 0;
    if (!(words >> name >> kilobytes)) continue;
    const auto it = wanted.find(name);
    if (it != wanted.end()) *it->second = kilobytes * 1024;
  }
  return state;
}

void LoadMeter::sample() {
  std::ifstream file("/proc/stat");
  std::string name;
  std::int64_t user = 0, nice = 0, system = 0, idle = 0, waiting = 0, irq = 0, soft_irq = 0;
  if (!(file >> name >> user >> nice >> system >> idle >> waiting >> irq >> soft_irq)) return;
  const std::int64_t busy = user + nice + system + irq + soft_irq;
  const std::int64_t total = busy + idle + waiting;
  elapsed_ = total_ > 0 ? total - total_ : 0;
  if (elapsed_ > 0)
    cpu_load_ =
        std::clamp(static_cast<float>(busy - busy_) / static_cast<float>(elapsed_), 0.0F, 1.0F);
  busy_ = busy;
  total_ = total;
}

std::optional<ProcessLoad> LoadMeter::process(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  if (!std::getline(file, text, '\0')) return std::nullopt;
  // The name, in brackets, may hold anything: what counts begins behind the last one.
  const std::size_t end_of_name = text.rfind(')');
  if (end_of_name == std::string::npos) return std::nullopt;
  std::istringstream words(text.substr(end_of_name + 1));
  std::string skipped;
  for (int i = 3; i < 14; ++i) words >> skipped;  // fields 3 to 13
  std::int64_t user = 0, system = 0, vsize_bytes = 0, rss_pages = 0;
  words >> user >> system;
  for (int i = 16; i < 23; ++i) words >> skipped;
  if (!(words >> vsize_bytes >> rss_pages)) return std::nullopt;
  ProcessLoad load;
  load.vsize_bytes = vsize_bytes;
  load.rss_bytes = rss_pages * sysconf(_SC_PAGESIZE);
  const auto [before, first] = ticks_.try_emplace(pid, user + system);
  if (!first && elapsed_ > 0)
    load.cpu_usage = std::clamp(
        static_cast<float>(user + system - before->second) / static_cast<float>(elapsed_), 0.0F,
        1.0F);
  before->second = user + system;
  return load;
}

}  // namespace fusion_slam
