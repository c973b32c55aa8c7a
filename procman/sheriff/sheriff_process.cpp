#include "procman/sheriff/sheriff_process.hpp"

#include <algorithm>
#include <iostream>

#include <unistd.h>

#include "libs/clock/clock.hpp"
#include "libs/messages/procman.hpp"
#include "procman_lcm/discovery_t.hpp"
#include "procman_lcm/output_t.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kOrdersPeriod_us = 1'000'000;

std::string unique_name() {
  char host[256] = {};
  gethostname(host, sizeof(host) - 1);
  return std::string("fusion-slam lab on ") + host + ", process " + std::to_string(getpid());
}

std::unique_ptr<SigningKey> load_key(const std::string& file) {
  return file.empty() ? nullptr : std::make_unique<SigningKey>(load_signing_key(file));
}

}  // namespace

SheriffProcess::SheriffProcess(const std::string& lcm_url, const std::string& key_file)
    : key_(load_key(key_file)), core_(unique_name()), mailbox_(lcm_url) {
  mailbox_.subscribe<procman_lcm::deputy_info_t>(
      "PM_INFO", [this](const auto& m) { core_.hear(from_message(m), wall_us(), steady_us()); });
  mailbox_.subscribe<procman_lcm::orders_t>(
      "PM_ORDERS",
      [this](const procman_lcm::orders_t& m) {
        if (m.sheriff_id != core_.name()) other_ = m.sheriff_id;
      },
      size_without_signature);
  mailbox_.subscribe<procman_lcm::output_t>("PM_OUTPUT", [this](const procman_lcm::output_t& m) {
    for (std::size_t i = 0; on_output_ && i < m.text.size(); ++i)
      on_output_(m.deputy_id, m.command_ids[i], m.text[i]);
  });
}

SheriffProcess::~SheriffProcess() {
  if (!in_command_) return;
  procman_lcm::discovery_t farewell{};
  farewell.utime = wall_us();
  farewell.transmitter_id = core_.name();
  farewell.nonce = 0;
  mailbox_.publish("PM_DISCOVER", farewell);
}

void SheriffProcess::ask() {
  procman_lcm::discovery_t question{};
  question.utime = wall_us();
  question.transmitter_id = core_.name();
  question.nonce = getpid();
  mailbox_.publish("PM_DISCOVER", question);
}

void SheriffProcess::discover(int wait_ms) {
  ask();
  const std::int64_t until_us = steady_us() + wait_ms * 1000LL;
  while (steady_us() < until_us)
    turn(static_cast<int>(std::clamp<std::int64_t>((until_us - steady_us()) / 1000, 1, 50)));
}

void SheriffProcess::take_command() {
  if (!other_.empty())
    throw OtherSheriff("another sheriff is giving orders: " + other_ +
                       ". Two would undo each other's orders: end that one first (status and logs "
                       "may be watched by many)");
  in_command_ = true;
}

void SheriffProcess::turn(int timeout_ms) {
  mailbox_.handle(timeout_ms);
  if (in_command_ && steady_us() - last_orders_us_ >= kOrdersPeriod_us) give_orders();
}

void SheriffProcess::give_orders() {
  last_orders_us_ = steady_us();
  // Each later than the one before, whatever the clock does.
  last_utime_us_ = std::max(last_utime_us_ + 1, wall_us());
  for (const Orders& orders : core_.orders(last_utime_us_)) {
    std::vector<std::uint8_t> bytes = bus_detail::encode(to_message(orders));
    mailbox_.publish_bytes("PM_ORDERS", key_ ? key_->sign("PM_ORDERS", bytes) : bytes);
  }
}

}  // namespace fusion_slam
