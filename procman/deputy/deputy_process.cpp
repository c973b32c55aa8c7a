#include "procman/deputy/deputy_process.hpp"

#include <iostream>
#include <stdexcept>

#include <unistd.h>

#include "libs/clock/clock.hpp"
#include "libs/clock_check/clock_pong.hpp"
#include "libs/messages/procman.hpp"
#include "procman_lcm/output_t.hpp"

namespace fusion_slam {
namespace {

constexpr int kTurn_ms = 20;
constexpr std::int64_t kInfoPeriod_us = 1'000'000;
constexpr std::int64_t kOutputPeriod_us = 100'000;
constexpr std::size_t kOutput_bytes = 50'000;  // a message of it is one datagram
constexpr std::int64_t kRefusalPeriod_us = 5'000'000;
constexpr std::int64_t kTwin_us = 600'000;

std::unique_ptr<SigningKey> load_key(const std::string& file) {
  return file.empty() ? nullptr : std::make_unique<SigningKey>(load_signing_key(file));
}

}  // namespace

DeputyProcess::DeputyProcess(const DeputyOptions& options)
    : options_(options),
      key_(load_key(options.key_file)),
      mailbox_(options.lcm_url),
      deputy_(options, key_ ? wall_us() : 0) {
  mailbox_.subscribe<procman_lcm::orders_t>(
      "PM_ORDERS", [this](const auto& m) { on_orders(m); },
      [this](const std::uint8_t* bytes, std::size_t size) {
        if (key_) return key_->verify("PM_ORDERS", bytes, size).value_or(0);
        return size_without_signature(bytes, size);
      });
  mailbox_.subscribe<procman_lcm::discovery_t>("PM_DISCOVER",
                                               [this](const auto& m) { on_discover(m); });
  mailbox_.subscribe<procman_lcm::deputy_info_t>("PM_INFO", [this](const auto& m) {
    if (looking_for_twin_ && m.deputy_id == options_.name) twin_ = true;
  });
  answer_clock_pings(mailbox_, options_.name);
}

void DeputyProcess::run(const std::atomic<bool>* stop) {
  look_for_twin();
  idle_since_us_ = steady_us();
  const auto idle_us = static_cast<std::int64_t>(1e6 * options_.until_idle_s);
  while (!*stop) {
    one_turn();
    if (!deputy_.core().commands().empty()) idle_since_us_ = steady_us();
    if (idle_us > 0 && steady_us() - idle_since_us_ > idle_us) break;
  }
  deputy_.core().stop_all();
  while (deputy_.core().any_running()) one_turn();
  publish_info();
  publish_output();
}

// Two deputies of one name would both run everything.
void DeputyProcess::look_for_twin() {
  const std::int64_t until_us = steady_us() + kTwin_us;
  while (steady_us() < until_us && !twin_) {
    procman_lcm::discovery_t question{};
    question.utime = wall_us();
    question.transmitter_id = options_.name;
    question.nonce = getpid();
    mailbox_.publish("PM_DISCOVER", question);
    for (int i = 0; i < 10 && !twin_; ++i) mailbox_.handle(kTurn_ms);
  }
  looking_for_twin_ = false;
  if (twin_)
    throw std::runtime_error("a deputy named \"" + options_.name +
                             "\" is on this network already: stop it, or give another --name");
}

void DeputyProcess::one_turn() {
  mailbox_.handle(kTurn_ms);
  const std::int64_t now = steady_us();
  const bool changed = deputy_.work(now);
  if (now - last_info_us_ >= kInfoPeriod_us) {
    deputy_.measure();
    publish_info();
  } else if (changed) {
    publish_info();
  }
  if (now - last_output_us_ >= kOutputPeriod_us) publish_output();
}

void DeputyProcess::on_orders(const procman_lcm::orders_t& message) {
  if (looking_for_twin_) return;  // they are given again every second
  const Orders orders = from_message(message);
  const OrdersVerdict verdict = deputy_.core().take(orders, wall_us(), steady_us());
  if (verdict == OrdersVerdict::kTooOld || verdict == OrdersVerdict::kOtherSheriff)
    refuse(orders, verdict);
}

void DeputyProcess::refuse(const Orders& orders, OrdersVerdict verdict) {
  if (steady_us() - last_refusal_us_ < kRefusalPeriod_us) return;
  last_refusal_us_ = steady_us();
  const std::string text =
      "orders of sheriff " + orders.sheriff + " refused: " + to_string(verdict);
  std::cerr << options_.name << ": " << text << std::endl;
  unsent_.push_back({"", text + "\n"});
}

void DeputyProcess::on_discover(const procman_lcm::discovery_t& message) {
  if (message.nonce == 0) deputy_.core().sheriff_left(message.transmitter_id);
  const bool mine = message.transmitter_id == options_.name && message.nonce == getpid();
  if (!mine && !looking_for_twin_) publish_info();
}

void DeputyProcess::publish_info() {
  last_info_us_ = steady_us();
  mailbox_.publish("PM_INFO", to_message(deputy_.info(wall_us())));
}

void DeputyProcess::publish_output() {
  last_output_us_ = steady_us();
  for (CommandOutput& output : deputy_.take_output()) unsent_.push_back(std::move(output));
  procman_lcm::output_t message{};
  std::size_t bytes = 0;
  const auto flush = [&] {
    if (message.text.empty()) return;
    message.utime = wall_us();
    message.deputy_id = options_.name;
    message.num_commands = static_cast<std::int16_t>(message.text.size());
    mailbox_.publish("PM_OUTPUT", message);
    message = {};
    bytes = 0;
  };
  for (CommandOutput& output : unsent_) {
    if (bytes + output.id.size() + output.text.size() > kOutput_bytes) flush();
    bytes += output.id.size() + output.text.size() + 10;
    message.command_ids.push_back(std::move(output.id));
    message.text.push_back(std::move(output.text));
  }
  flush();
  unsent_.clear();
}

}  // namespace fusion_slam
