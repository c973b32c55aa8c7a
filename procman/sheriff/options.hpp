// The sheriff's command line.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace fusion_slam {

enum class SheriffTask { kUp, kDown, kRestart, kStatus, kLogs, kRun, kCheck };

struct SheriffOptions {
  SheriffTask task = SheriffTask::kStatus;
  std::string file;                // lab configuration
  std::vector<std::string> names;  // commands and groups; none: all of the file
  std::string script;              // of kRun
  std::string lcm_url;
  std::string key_file;
  double timeout_s = 30.0;
  bool watch = false;
  bool json = false;
};

// Nothing: exit with *exit_code (help was shown, or the usage was wrong).
std::optional<SheriffOptions> parse_sheriff_options(int argc, char** argv, int* exit_code);

}  // namespace fusion_slam
