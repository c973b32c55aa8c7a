#include "libs/procman/deputy_core.hpp"

#include <algorithm>
#include <set>

namespace fusion_slam {

const char* to_string(OrdersVerdict verdict) {
  switch (verdict) {
    case OrdersVerdict::kTaken:
      return "taken";
    case OrdersVerdict::kForAnother:
      return "they are for another deputy";
    case OrdersVerdict::kTooOld:
      return "their time is more than 60 s off this machine's clock: synchronise the clocks "
             "(docs/lab.md)";
    case OrdersVerdict::kOlder:
      return "they are older than the last that were taken";
    case OrdersVerdict::kOtherSheriff:
      return "another sheriff is giving orders";
  }
  return "";
}

OrdersVerdict DeputyCore::take(const Orders& orders, std::int64_t utime_us, std::int64_t now_us) {
  if (orders.deputy != deputy_) return OrdersVerdict::kForAnother;
  if (ending_) return OrdersVerdict::kOlder;
  // Written so that no utime, however forged, overflows.
  if (orders.utime_us < utime_us - kGreatestAge_us || orders.utime_us > utime_us + kGreatestAge_us)
    return OrdersVerdict::kTooOld;
  const bool same = orders.sheriff == sheriff_;
  if (!same && now_us < sheriff_until_us_) return OrdersVerdict::kOtherSheriff;
  if (orders.utime_us <= last_utime_us_) return OrdersVerdict::kOlder;
  last_utime_us_ = orders.utime_us;
  sheriff_ = orders.sheriff;
  sheriff_until_us_ = now_us + kSheriffHolds_us;
  std::set<std::string> ordered;
  for (const DesiredCommand& desired : orders.commands) {
    const bool known = commands_.count(desired.spec.id) > 0;
    if (!known && commands_.size() >= kMostCommands) continue;
    ordered.insert(desired.spec.id);
    commands_.try_emplace(desired.spec.id, desired.spec).first->second.order(desired);
  }
  for (auto& [id, machine] : commands_)
    if (ordered.count(id) == 0) machine.remove();
  return OrdersVerdict::kTaken;
}

void DeputyCore::sheriff_left(const std::string& sheriff) {
  if (sheriff == sheriff_) sheriff_until_us_ = 0;
}

void DeputyCore::stop_all() {
  ending_ = true;
  for (auto& [id, machine] : commands_) machine.remove();
}

std::vector<DeputyCore::Step> DeputyCore::steps(std::int64_t now_us) {
  std::vector<Step> result;
  for (auto it = commands_.begin(); it != commands_.end();) {
    const auto action = it->second.step(now_us);
    if (action != CommandMachine::Action::kNothing) result.push_back({it->first, action});
    it = it->second.removable() ? commands_.erase(it) : std::next(it);
  }
  return result;
}

CommandMachine* DeputyCore::find(const std::string& id) {
  const auto it = commands_.find(id);
  return it == commands_.end() ? nullptr : &it->second;
}

bool DeputyCore::any_running() const {
  return std::any_of(commands_.begin(), commands_.end(),
                     [](const auto& entry) { return entry.second.status().pid != 0; });
}

}  // namespace fusion_slam
