// An LCM network that nobody else hears.
#pragma once

#include <string>

namespace fusion_slam {

struct PrivateNetwork {
  std::string url;          // for every process of the run
  std::string description;  // for people
};

// Moves this process (call it before there are threads; children inherit it) into a network
// namespace of its own with lo up and a multicast route, as root or through a user namespace. Where
// the kernel forbids both: stays, and names a multicast group and port of this process's own on
// this host (TTL 0). Never fails.
PrivateNetwork enter_private_network();

}  // namespace fusion_slam
