// What a deputy may run. Whoever can send to the network can give orders: so only programs below
// certain folders, with no environment but harmless variables.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "libs/procman/exec_line.hpp"

namespace fusion_slam {

struct Allowed {
  bool anything = false;                       // programs and variables
  std::vector<std::filesystem::path> folders;  // and all below them
  // Besides LCM_DEFAULT_URL, TZ, and what begins with FUSION_SLAM_ or LCM_. Variables such as
  // LD_PRELOAD would make any program run anything.
  std::set<std::string> variables;
};

// The program's real path (links followed), or an empty path and `why`. A name without a `/` is
// looked for in the folders, then in `search_path` ("/usr/bin:/bin").
std::filesystem::path find_allowed(const Allowed& allowed, const ExecLine& line,
                                   const std::string& search_path, std::string* why);

}  // namespace fusion_slam
