#include "libs/process/private_network.hpp"

#include <cstring>
#include <fstream>

#include <arpa/inet.h>
#include <net/if.h>
#include <net/route.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

bool bring_up_loopback() {
  const int control = socket(AF_INET, SOCK_DGRAM, 0);
  if (control < 0) return false;
  ifreq interface {};
  std::strncpy(interface.ifr_name, "lo", IFNAMSIZ - 1);
  interface.ifr_flags = IFF_UP | IFF_RUNNING | IFF_LOOPBACK | IFF_MULTICAST;
  bool ok = ioctl(control, SIOCSIFFLAGS, &interface) == 0;
  // route add -net 224.0.0.0 netmask 240.0.0.0 dev lo
  rtentry route{};
  const auto address = [](sockaddr* out, const char* text) {
    auto* in = reinterpret_cast<sockaddr_in*>(out);
    in->sin_family = AF_INET;
    inet_pton(AF_INET, text, &in->sin_addr);
  };
  address(&route.rt_dst, "224.0.0.0");
  address(&route.rt_genmask, "240.0.0.0");
  char device[] = "lo";
  route.rt_dev = device;
  route.rt_flags = RTF_UP;
  ok = ok && ioctl(control, SIOCADDRT, &route) == 0;
  close(control);
  return ok;
}

bool unshare_as_user() {
  const uid_t uid = getuid();
  const gid_t gid = getgid();
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  // Files stay ours: the same ids inside as outside.
  std::ofstream("/proc/self/setgroups") << "deny";
  std::ofstream("/proc/self/uid_map") << uid << " " << uid << " 1";
  std::ofstream("/proc/self/gid_map") << gid << " " << gid << " 1";
  return true;
}

}  // namespace

PrivateNetwork enter_private_network() {
  const bool entered = unshare(CLONE_NEWNET) == 0 || unshare_as_user();
  if (entered && bring_up_loopback())
    return {"udpm://239.255.76.67:7667?ttl=0", "a network namespace of its own"};
  const unsigned pid = static_cast<unsigned>(getpid());
  const std::string group =
      "239.255." + std::to_string(77 + (pid >> 8) % 100) + "." + std::to_string(1 + pid % 250);
  const std::string port = std::to_string(20'000 + pid % 20'000);
  return {"udpm://" + group + ":" + port + "?ttl=0",
          "multicast group " + group + ":" + port + " of this host (namespaces are not permitted)"};
}

}  // namespace fusion_slam
