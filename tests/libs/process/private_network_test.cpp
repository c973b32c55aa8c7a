#include "libs/process/private_network.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

// In a child: sends itself a datagram over LCM's multicast group. 0: it came back.
int multicast_round_trip() {
  const int receiver = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(7667);
  inet_pton(AF_INET, "239.255.76.67", &address.sin_addr);
  if (bind(receiver, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) return 2;
  ip_mreq membership{};
  membership.imr_multiaddr = address.sin_addr;
  membership.imr_interface.s_addr = INADDR_ANY;
  if (setsockopt(receiver, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) != 0)
    return 3;
  timeval timeout{2, 0};
  setsockopt(receiver, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof(timeout));
  const int sender = socket(AF_INET, SOCK_DGRAM, 0);
  if (sendto(sender, "x", 1, 0, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 1)
    return 4;
  char byte = 0;
  return recv(receiver, &byte, 1, 0) == 1 && byte == 'x' ? 0 : 5;
}

TEST(PrivateNetwork, MulticastComesBackInside) {
  const pid_t child = fork();
  if (child == 0) {
    const PrivateNetwork network = enter_private_network();
    if (network.url.find("239.255.76.67:7667") == std::string::npos) _exit(77);
    _exit(multicast_round_trip());
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 77)
    GTEST_SKIP() << "skipped: network namespaces are not permitted here";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace fusion_slam
