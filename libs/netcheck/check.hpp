// The result of one check of this machine, for people.
#pragma once

#include <string>

namespace fusion_slam {

enum class CheckState {
  kGood,
  kWarning,  // works, but something will not
  kFault,    // has to be mended before a robot can be mapped
};

struct CheckResult {
  std::string name;
  CheckState state = CheckState::kGood;
  std::string found;  // what was found, in plain English
  std::string
      command;  // what to type (as root where it changes the system) to mend it; empty when good
};

}  // namespace fusion_slam
