// The processes of a run: the services and lcm-logger, started together, watched, stopped together.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "libs/process/child.hpp"
#include "logplayer/run/options.hpp"

namespace fusion_slam {

// A process ended before it was told to; what() holds its last 20 lines.
class ProcessDied : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Crew {
 public:
  // Starts everything; output goes to OUT/logs/NAME.log. Throws std::runtime_error naming what
  // can't be started.
  Crew(const RunOptions& options, const std::string& url);

  void check();  // throws ProcessDied
  void stop();   // services first, then the logger so that it has everything

 private:
  std::vector<Child> services_;
  std::vector<Child> logger_;  // none or one
};

}  // namespace fusion_slam
