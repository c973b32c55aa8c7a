#include "procman/doctor/machines.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace fusion_slam {
namespace {

constexpr int kPings = 50;
constexpr int kPeriod_ms = 50;
constexpr double kFaultOffset_ms = 10.0;
constexpr double kWarningOffset_ms = 2.0;
constexpr double kFaultLoss = 0.05;

std::string describe(const MachineReply& reply, double loss) {
  const ClockEstimate& clock = reply.clock;
  char text[200];
  std::snprintf(text, sizeof text,
                "clock %+.3f ms (+- %.3f), round trip %.2f ms (longest %.2f), %.0f %% unanswered",
                clock.offset_ms, clock.uncertainty_ms, clock.round_trip_ms_median,
                clock.round_trip_ms_max, 100.0 * loss);
  return text;
}

}  // namespace

std::vector<CheckResult> judge_machines(const std::map<std::string, MachineReply>& replies,
                                        int n_pings) {
  if (replies.empty())
    return {{"machines", CheckState::kFault, "no deputy answered",
             "on each machine: LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=1' fusion-slam lab "
             "deputy --name NAME"}};
  std::vector<CheckResult> results;
  for (const auto& [name, reply] : replies) {
    const double loss = 1.0 - static_cast<double>(reply.answered) / n_pings;
    // What the measurement's own uncertainty does not explain.
    const double off_ms =
        std::max(0.0, std::abs(reply.clock.offset_ms) - reply.clock.uncertainty_ms);
    CheckResult result{name, CheckState::kGood, describe(reply, loss), ""};
    if (off_ms > kWarningOffset_ms || loss > 0.0) result.state = CheckState::kWarning;
    if (off_ms > kFaultOffset_ms || loss > kFaultLoss) result.state = CheckState::kFault;
    if (off_ms > kWarningOffset_ms)
      result.command = "apt-get install chrony    # and its settings as in docs/lab.md";
    else if (loss > kFaultLoss)
      result.command =
          "fusion-slam doctor    # on both machines; see docs/lab.md, Several machines";
    results.push_back(result);
  }
  return results;
}

std::vector<CheckResult> check_machines(const std::string& lcm_url) {
  Mailbox mailbox(lcm_url);
  return judge_machines(ask_clocks(mailbox, "doctor", kPings, kPeriod_ms), kPings);
}

}  // namespace fusion_slam
