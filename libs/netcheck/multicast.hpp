// Does LCM's multicast work here, and do large messages survive? Each function tries it with
// sockets of its own.
#pragma once

#include <vector>

#include "libs/netcheck/check.hpp"
#include "libs/netcheck/udpm_url.hpp"

namespace fusion_slam {

// All of the below, in an order in which the commands can be typed.
std::vector<CheckResult> check_multicast(const UdpmUrl& url);

// Which device packets for the group leave by (the kernel's routing decides, as it does for LCM),
// and whether that device is up and multicasts.
CheckResult check_route(const UdpmUrl& url);

// Sends a real LCM datagram on channel FUSION_SLAM_DOCTOR, which nobody listens to, and waits for
// it to come back.
CheckResult check_loops_back(const UdpmUrl& url);

// Where messages reach with the URL's ttl, by the device of check_route.
CheckResult check_reach(const UdpmUrl& url);

// What the kernel grants of the receive buffer that is asked for. Wanted: 2 MB, about five of the
// largest messages.
CheckResult check_receive_buffer(const UdpmUrl& url);

// Puts a message of 400 kB, the largest this project sends, into that buffer: is all of it still
// there?
CheckResult check_large_message(const UdpmUrl& url);

}  // namespace fusion_slam
