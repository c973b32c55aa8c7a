// A process's bus in a test.
#pragma once

#include <string>

#include "libs/bus/bus.hpp"

namespace fusion_slam {

inline BusOptions named_bus(const std::string& process, Mode mode) {
  BusOptions options;
  options.process = process;
  options.mode = mode;
  return options;
}

// Its messages wait for nobody older.
inline BusOptions test_bus(const std::string& process, Mode mode = Mode::kLive) {
  BusOptions options = named_bus(process, mode);
  options.merge_wait_us = 0;
  return options;
}

}  // namespace fusion_slam
