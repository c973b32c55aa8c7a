// The sheriff on the network: PM_INFO, PM_OUTPUT, PM_ORDERS (another's) in; PM_ORDERS, PM_DISCOVER
// out. Interoperable with procman's own deputy.
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include "libs/authentication/signature.hpp"
#include "libs/bus/mailbox.hpp"
#include "libs/procman/sheriff_core.hpp"

namespace fusion_slam {

// what() names it and says what to do.
class OtherSheriff : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class SheriffProcess {
 public:
  using OnOutput = std::function<void(const std::string& deputy, const std::string& command,
                                      const std::string& text)>;

  // key_file empty: orders are not signed. Throws std::runtime_error: no network, no such key.
  SheriffProcess(const std::string& lcm_url, const std::string& key_file);
  ~SheriffProcess();  // lets another sheriff give orders at once
  SheriffProcess(const SheriffProcess&) = delete;
  SheriffProcess& operator=(const SheriffProcess&) = delete;

  SheriffCore& core() { return core_; }
  void on_output(OnOutput handler) { on_output_ = std::move(handler); }

  // Asks who is there, and listens for wait_ms.
  void discover(int wait_ms);

  // From now on turn() gives orders, once a second and after changed(). Throws OtherSheriff when
  // another one has been heard giving orders since discover().
  void take_command();
  void changed() { last_orders_us_ = 0; }

  // Listens for up to timeout_ms and gives the orders that are due.
  void turn(int timeout_ms);

 private:
  void ask();
  void give_orders();

  std::unique_ptr<SigningKey> key_;
  SheriffCore core_;
  OnOutput on_output_;
  std::string other_;  // sheriff that gives orders
  bool in_command_ = false;
  std::int64_t last_orders_us_ = 0;
  std::int64_t last_utime_us_ = 0;
  Mailbox mailbox_;
};

}  // namespace fusion_slam
