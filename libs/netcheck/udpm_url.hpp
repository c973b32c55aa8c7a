// LCM's multicast URLs: udpm://239.255.76.67:7667?ttl=1&recv_buf_size=4194304, each part optional.
#pragma once

#include <cstdint>
#include <string>

namespace fusion_slam {

struct UdpmUrl {
  std::string group = "239.255.76.67";
  std::uint16_t port = 7667;
  int ttl = 0;
  int recv_buf_size_bytes = 4 << 20;  // what libs/bus asks for when the URL doesn't say
};

// An empty URL is LCM_DEFAULT_URL from the environment, or LCM's default. Throws
// std::invalid_argument saying what is wrong with it, for other providers too (memq://, file://,
// tcpq://: they have no multicast to check).
UdpmUrl parse_udpm_url(const std::string& url);

}  // namespace fusion_slam
