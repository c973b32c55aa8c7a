// Between procman's LCM types and libs/procman. Pure functions; from_message takes any message that
// the guard let pass: names of any length, any numbers.
#pragma once

#include "libs/procman/command.hpp"
#include "procman_lcm/deputy_info_t.hpp"
#include "procman_lcm/orders_t.hpp"

namespace fusion_slam {

procman_lcm::deputy_info_t to_message(const DeputyInfo& info);
DeputyInfo from_message(const procman_lcm::deputy_info_t& message);

procman_lcm::orders_t to_message(const Orders& orders);
// Signals outside 1..64 become 2, times that are no time from 0 to 3600 s become 7 s.
Orders from_message(const procman_lcm::orders_t& message);

}  // namespace fusion_slam
