// Checks of the lab's machines, as the network between them shows them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "libs/clock_check/clock_pong.hpp"
#include "libs/netcheck/check.hpp"

namespace fusion_slam {

// Pings the deputies 50 times within 3.5 s. Throws std::runtime_error when there is no LCM network.
std::vector<CheckResult> check_machines(const std::string& lcm_url);

// A result a machine that answered: a fault when its clock is certainly more than 10 ms off or more
// than 5 % of the pings got no answer, a warning above 2 ms or 0 %. One fault when nobody answered.
std::vector<CheckResult> judge_machines(const std::map<std::string, MachineReply>& replies,
                                        int n_pings);

}  // namespace fusion_slam
