#include "libs/clock_check/clock_pong.hpp"

#include <set>
#include <vector>

#include <unistd.h>

#include "libs/clock/clock.hpp"
#include "procman_lcm/discovery_t.hpp"

namespace fusion_slam {
namespace {

constexpr int kLastAnswers_ms = 1000;
constexpr std::size_t kMostMachines = 1000;

// Numbers of this process's pings: others' answers don't count.
std::int64_t first_number() { return (static_cast<std::int64_t>(getpid()) << 32) | 1; }

}  // namespace

void answer_clock_pings(Mailbox& mailbox, const std::string& name) {
  mailbox.listen<procman_lcm::discovery_t>("CLOCK_PING",
                                           [&mailbox, name](const procman_lcm::discovery_t& ping) {
                                             procman_lcm::discovery_t pong{};
                                             pong.utime = wall_us();
                                             pong.transmitter_id = name;
                                             pong.nonce = ping.nonce;
                                             mailbox.publish("CLOCK_PONG", pong);
                                           });
}

std::map<std::string, MachineReply> ask_clocks(Mailbox& mailbox, const std::string& name, int n,
                                               int period_ms) {
  std::vector<std::int64_t> sent_us;
  std::map<std::string, std::vector<ClockSample>> samples;
  std::map<std::string, std::set<std::int64_t>> seen;  // an answer may come twice
  mailbox.subscribe<procman_lcm::discovery_t>(
      "CLOCK_PONG", [&](const procman_lcm::discovery_t& pong) {
        const std::int64_t number = pong.nonce - first_number();
        if (number < 0 || number >= static_cast<std::int64_t>(sent_us.size())) return;
        if (samples.size() >= kMostMachines && samples.count(pong.transmitter_id) == 0) return;
        if (!seen[pong.transmitter_id].insert(number).second) return;
        samples[pong.transmitter_id].push_back(
            {sent_us[static_cast<std::size_t>(number)], pong.utime, wall_us()});
      });
  const auto wait = [&](int ms) {
    const std::int64_t until_us = steady_us() + ms * 1000LL;
    while (steady_us() < until_us) mailbox.handle(1);
  };
  for (int i = 0; i < n; ++i) {
    procman_lcm::discovery_t ping{};
    ping.transmitter_id = name;
    ping.nonce = first_number() + i;
    ping.utime = wall_us();
    sent_us.push_back(ping.utime);
    mailbox.publish("CLOCK_PING", ping);
    wait(period_ms);
  }
  wait(kLastAnswers_ms);
  std::map<std::string, MachineReply> result;
  for (const auto& [machine, list] : samples)
    result[machine] = {static_cast<int>(list.size()), estimate_clock(list)};
  return result;
}

}  // namespace fusion_slam
