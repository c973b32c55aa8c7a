// CLOCK_PING and CLOCK_PONG: procman_lcm.discovery_t, so that no type is added for it. A ping holds
// the asker's name and a number; the answer the answering machine's clock, its name, and the
// number.
#pragma once

#include <map>
#include <string>

#include "libs/bus/mailbox.hpp"
#include "libs/clock_check/clock_estimate.hpp"

namespace fusion_slam {

// Answers pings, on the reader's thread, as long as the mailbox lives.
void answer_clock_pings(Mailbox& mailbox, const std::string& name);

struct MachineReply {
  int answered = 0;
  ClockEstimate clock;
};

// Asks `n` times, `period_ms` apart, who is there and what time it is; waits another second for
// the last answers. By name of the machine.
std::map<std::string, MachineReply> ask_clocks(Mailbox& mailbox, const std::string& name, int n,
                                               int period_ms);

}  // namespace fusion_slam
