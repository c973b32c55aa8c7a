// A process's bus in a test: its messages wait for nobody older.
#pragma once

#include <string>

#include "libs/bus/bus.hpp"

namespace fusion_slam {

inline BusOptions test_bus(const std::string& process, Mode mode = Mode::kLive) {
  BusOptions options;
  options.process = process;
  options.mode = mode;
  options.merge_wait_us = 0;
  return options;
}

}  // namespace fusion_slam
