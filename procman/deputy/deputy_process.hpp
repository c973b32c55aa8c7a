// The deputy on the network: PM_ORDERS, PM_DISCOVER, CLOCK_PING in; PM_INFO, PM_OUTPUT,
// PM_DISCOVER, CLOCK_PONG out. Interoperable with procman's own sheriff.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "libs/authentication/signature.hpp"
#include "libs/bus/mailbox.hpp"
#include "procman/deputy/deputy.hpp"
#include "procman_lcm/deputy_info_t.hpp"
#include "procman_lcm/discovery_t.hpp"
#include "procman_lcm/orders_t.hpp"

namespace fusion_slam {

class DeputyProcess {
 public:
  // Throws std::runtime_error: no network, a key that can't be used.
  explicit DeputyProcess(const DeputyOptions& options);

  // Until *stop, or idle for as long as the options say; then stops all commands, each with its
  // signal and time. Throws std::runtime_error when a deputy of this name is on the network
  // already.
  void run(const std::atomic<bool>* stop);

 private:
  void on_orders(const procman_lcm::orders_t& message);
  void on_discover(const procman_lcm::discovery_t& message);
  void look_for_twin();
  void one_turn();
  void publish_info();
  void publish_output();
  void refuse(const Orders& orders, OrdersVerdict verdict);

  DeputyOptions options_;
  std::unique_ptr<SigningKey> key_;
  Mailbox mailbox_;
  Deputy deputy_;
  bool looking_for_twin_ = true;
  bool twin_ = false;
  std::int64_t last_info_us_ = 0;
  std::int64_t last_output_us_ = 0;
  std::int64_t last_refusal_us_ = -1'000'000'000;
  std::int64_t idle_since_us_ = 0;
  std::vector<CommandOutput> unsent_;
};

}  // namespace fusion_slam
