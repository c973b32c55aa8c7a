// A deputy for configurations of one machine, so that nothing has to be set up for it.
#pragma once

#include <string>

namespace fusion_slam {

constexpr const char* kLocalDeputy = "localhost";

// Starts procman-deputy, which lies beside this program, in the background under the name
// "localhost": it may run this installation's programs, lcm-logger and lcm-logplayer, and ends by
// itself 20 s after its last command is gone. Returns where it writes its output. Throws
// std::runtime_error when it can't be started.
std::string start_local_deputy(const std::string& lcm_url, const std::string& key_file);

}  // namespace fusion_slam
