// The loop detector's reports from before this viewer was started. LOOP_CANDIDATEs are said once;
// who said them keeps the latest thousands (libs/bus/outbox) and sends them again when asked.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "fusion_slam/status_t.hpp"
#include "libs/bus/bus.hpp"

namespace fusion_slam {

class LoopHistory {
 public:
  static constexpr std::int64_t kMost = 4000;  // reports asked for, the latest
  static constexpr int kTries = 5;             // answers may be lost, and some are forgotten

  // A process's STATUS, of the bus's reader thread: asks for reports that have not come.
  void hear(const status_t& status, Bus& bus);

 private:
  std::map<std::pair<std::string, std::int32_t>, int> tries_;  // of a process, by its pid
};

}  // namespace fusion_slam
