// Runs a script of a lab configuration, an action at a time, on a SheriffCore. A script never times
// out. Not thread-safe.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "libs/procman/sheriff_core.hpp"

namespace fusion_slam {

class ScriptRunner {
 public:
  // Throws LabConfigError when the configuration has no such script. Keeps a copy of it.
  ScriptRunner(LabConfig config, const std::string& script);

  // Goes on as far as it can at now_us (monotonic). True when the script is done.
  bool step(SheriffCore* sheriff, std::int64_t now_us);

  // For people: `start group "services" wait "running"`; empty when done.
  std::string waiting_for() const { return waiting_for_; }

 private:
  std::vector<std::string> ids(const Target& target) const;
  void order(const ScriptAction& action, SheriffCore* sheriff) const;
  bool is_over(const ScriptAction& action, const SheriffCore& sheriff, std::int64_t now_us) const;

  LabConfig config_;
  std::vector<std::pair<const Script*, std::size_t>> stack_;  // scripts that call each other
  bool ordered_ = false;  // the current action's orders are given, it waits
  std::int64_t since_us_ = 0;
  std::string waiting_for_;
};

// "start group \"services\"".
std::string describe(const ScriptAction& action);

}  // namespace fusion_slam
