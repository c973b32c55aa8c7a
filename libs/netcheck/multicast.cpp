#include "libs/netcheck/multicast.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include <net/if.h>
#include <net/route.h>
#include <poll.h>
#include <sys/ioctl.h>

#include "libs/netcheck/socket.hpp"

namespace fusion_slam {
namespace {

constexpr int kWantedBuffer_bytes = 2 << 20;
constexpr int kLargestMessage_bytes = 400'000;
constexpr int kDatagram_bytes = 60'000;
constexpr int kLoopTimeout_ms = 500;
const char kMendBuffer[] = "sysctl -w net.core.rmem_max=4194304";

struct Device {
  std::string name;
  unsigned flags = 0;
};

std::optional<Device> find_device(const std::string& name) {
  const UdpSocket probe;
  ifreq request{};
  std::strncpy(request.ifr_name, name.c_str(), IFNAMSIZ - 1);
  if (ioctl(probe.handle(), SIOCGIFFLAGS, &request) != 0) return std::nullopt;
  return Device{name, static_cast<unsigned short>(request.ifr_flags)};
}

// Longest match for the group in the kernel's main table, of equal ones the lowest metric.
std::optional<Device> route_device(const UdpmUrl& url) {
  const std::uint32_t group =
      socket_address(url.group, 0).sin_addr.s_addr;  // as the table has it: network order
  std::ifstream table("/proc/net/route");
  std::string line;
  std::getline(table, line);  // titles
  std::string best;
  std::pair<std::uint32_t, std::int64_t> best_rank;
  while (std::getline(table, line)) {
    std::istringstream columns(line);
    std::string name;
    std::string gateway;
    std::uint32_t destination = 0;
    std::uint32_t flags = 0;
    std::uint32_t mask = 0;
    std::int64_t ignored = 0;
    std::int64_t metric = 0;
    columns >> name >> std::hex >> destination >> gateway >> flags >> std::dec >> ignored >>
        ignored >> metric >> std::hex >> mask;
    if (!columns || (flags & RTF_UP) == 0 || (flags & RTF_REJECT) != 0 ||
        (group & mask) != destination)
      continue;
    const std::pair<std::uint32_t, std::int64_t> rank{ntohl(mask), -metric};
    if (!best.empty() && rank <= best_rank) continue;
    best = name;
    best_rank = rank;
  }
  return best.empty() ? std::nullopt : find_device(best);
}

int sysctl_value(const std::string& path) {
  int value = -1;
  std::ifstream("/proc/sys/" + path) >> value;
  return value;
}

// Magic LC02, sequence number, channel with its NUL, payload: what LCM sends for a small message.
std::string lcm_datagram(const std::string& payload) {
  using std::string_literals::operator""s;
  return "LC02"s + std::string(4, '\0') + "FUSION_SLAM_DOCTOR"s + std::string(1, '\0') + payload;
}

bool prepare_sender(UdpSocket* sender, int ttl) {
  const auto ttl_byte = static_cast<unsigned char>(ttl);
  const unsigned char yes = 1;
  return sender->set(IPPROTO_IP, IP_MULTICAST_TTL, ttl_byte) &&
         sender->set(IPPROTO_IP, IP_MULTICAST_LOOP, yes);
}

bool send_to(const UdpSocket& sender, const std::string& group, std::uint16_t port,
             const std::string& data) {
  const sockaddr_in target = socket_address(group, port);
  return sendto(sender.handle(), data.data(), data.size(), 0,
                reinterpret_cast<const sockaddr*>(&target),
                sizeof target) == static_cast<ssize_t>(data.size());
}

}  // namespace

std::vector<CheckResult> check_multicast(const UdpmUrl& url) {
  std::vector<CheckResult> results = {check_route(url)};
  if (results.back().state == CheckState::kFault)
    return results;  // nothing else can be tried before
  results.push_back(check_loops_back(url));
  results.push_back(check_reach(url));
  results.push_back(check_receive_buffer(url));
  results.push_back(check_large_message(url));
  return results;
}

CheckResult check_route(const UdpmUrl& url) {
  CheckResult result{"route", CheckState::kGood, "", ""};
  const std::optional<Device> device = route_device(url);
  if (!device) {
    const std::optional<Device> lo = find_device("lo");
    const bool lo_is_up = lo && (lo->flags & IFF_UP) != 0;
    result.state = CheckState::kFault;
    result.found =
        "no route for 224.0.0.0/4 (LCM's group " + url.group + ")" +
        (lo_is_up ? "" : ", and device lo is down") +
        ". On one machine, send it over lo; in a lab, over the lab's device instead of lo";
    result.command = std::string(lo_is_up ? "" : "ip link set lo up && ") +
                     "ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo";
    return result;
  }
  result.found = url.group + " goes by device " + device->name;
  if ((device->flags & IFF_MULTICAST) == 0) {
    // Linux 6 loops back over lo without the flag; real devices filter what comes in.
    const bool is_lo = (device->flags & IFF_LOOPBACK) != 0;
    result.state = is_lo ? CheckState::kWarning : CheckState::kFault;
    result.found += ", which has its multicast flag off";
    result.command = "ip link set " + device->name + " multicast on";
  }
  return result;
}

CheckResult check_loops_back(const UdpmUrl& url) {
  CheckResult result{"loopback", CheckState::kGood,
                     "a message on " + url.group + ":" + std::to_string(url.port) + " comes back",
                     ""};
  const auto fault = [&result](const std::string& found, const std::string& command) {
    result.state = CheckState::kFault;
    result.found = found;
    result.command = command;
    return result;
  };
  UdpSocket receiver;
  if (!receiver.join(url.group, url.port)) {
    return fault(
        "cannot join " + url.group + ":" + std::to_string(url.port) + ": " + std::strerror(errno),
        "ss --udp --listening --processes 'sport = :" + std::to_string(url.port) + "'");
  }
  UdpSocket sender;
  const std::string sent = lcm_datagram("doctor " + std::to_string(getpid()));
  if (!prepare_sender(&sender, url.ttl) || !send_to(sender, url.group, url.port, sent)) {
    return fault("cannot send to " + url.group + ": " + std::strerror(errno),
                 "ip route get " + url.group);
  }
  // Other traffic may come first: a bounded number of messages and a bounded time for each.
  std::vector<char> buffer(1 << 16);
  for (int i = 0; i < 1000; ++i) {
    pollfd waiting{receiver.handle(), POLLIN, 0};
    if (poll(&waiting, 1, kLoopTimeout_ms) <= 0) break;
    const ssize_t n = recv(receiver.handle(), buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (n >= 0 && sent == std::string(buffer.data(), static_cast<std::size_t>(n))) return result;
  }
  const std::optional<Device> device = route_device(url);
  if (device && (device->flags & IFF_MULTICAST) == 0) {
    return fault(
        "a message to " + url.group + " was sent over " + device->name + " but did not come back",
        "ip link set " + device->name + " multicast on");
  }
  return fault("a message to " + url.group + " was sent but did not come back: a firewall drops it",
               "iptables -I INPUT -d 224.0.0.0/4 -j ACCEPT");
}

CheckResult check_reach(const UdpmUrl& url) {
  CheckResult result{"reach", CheckState::kGood, "", ""};
  const std::optional<Device> device = route_device(url);
  const bool only_here = device && (device->flags & IFF_LOOPBACK) != 0;
  if (url.ttl == 0) {
    result.found = "ttl 0: messages stay on this machine (several machines: --lcm-url 'udpm://" +
                   url.group + ":" + std::to_string(url.port) + "?ttl=1')";
  } else if (only_here) {
    result.state = CheckState::kWarning;
    result.found = "ttl " + std::to_string(url.ttl) +
                   " asks for other machines, but the route keeps everything on this one";
    result.command =
        "ip route del 224.0.0.0/4 dev lo && ip route add 224.0.0.0/4 dev $(ip -o route get 1.1.1.1 "
        "| sed 's/.* dev \\([^ ]*\\).*/\\1/')";
  } else if (url.ttl == 1) {
    result.found = "ttl 1: messages reach the local network";
  } else {
    result.state = CheckState::kWarning;
    result.found = "ttl " + std::to_string(url.ttl) + ": messages may leave the local network";
    result.command =
        "export LCM_DEFAULT_URL='udpm://" + url.group + ":" + std::to_string(url.port) + "?ttl=1'";
  }
  return result;
}

CheckResult check_receive_buffer(const UdpmUrl& url) {
  UdpSocket probe;
  probe.set(SOL_SOCKET, SO_RCVBUF, url.recv_buf_size_bytes);
  // The kernel doubles the number for its own bookkeeping and says the double.
  const int granted = probe.get_int(SOL_SOCKET, SO_RCVBUF) / 2;
  const int by_default = sysctl_value("net/core/rmem_default");
  CheckResult result{"receive buffer", CheckState::kGood,
                     "asked for " + std::to_string(url.recv_buf_size_bytes) + " bytes, granted " +
                         std::to_string(granted),
                     ""};
  const int maximum = sysctl_value("net/core/rmem_max");
  if (maximum >= 0) result.found += " (net.core.rmem_max = " + std::to_string(maximum) + ")";
  if (granted >= kWantedBuffer_bytes) {
    if (by_default >= 0 && by_default < 2 * kLargestMessage_bytes) {
      result.state = CheckState::kWarning;
      result.found +=
          "; but lcm-logger and lcm-spy, unless their --lcm-url says recv_buf_size, get " +
          std::to_string(by_default) + " and lose large messages";
      result.command = "sysctl -w net.core.rmem_default=4194304";
    }
    return result;
  }
  result.state = CheckState::kFault;
  result.command = kMendBuffer;
  if (maximum >= kWantedBuffer_bytes) {
    result.found += ": the URL asks for too little, 2 MB at least";
    result.command = "export LCM_DEFAULT_URL='udpm://" + url.group + ":" +
                     std::to_string(url.port) + "?ttl=" + std::to_string(url.ttl) +
                     "&recv_buf_size=4194304'";
  } else {
    result.found += ": large messages will be lost";
  }
  return result;
}

CheckResult check_large_message(const UdpmUrl& url) {
  CheckResult result{"large messages", CheckState::kGood, "", ""};
  UdpSocket receiver;
  receiver.set(SOL_SOCKET, SO_RCVBUF, url.recv_buf_size_bytes);
  UdpSocket sender;
  const int sent = (kLargestMessage_bytes + kDatagram_bytes - 1) / kDatagram_bytes;
  // On a port of its own, and never beyond this machine.
  bool ok = receiver.join(url.group, 0) && prepare_sender(&sender, 0);
  for (int i = 0; ok && i < sent; ++i)
    ok = send_to(sender, url.group, receiver.port(), std::string(kDatagram_bytes, 'x'));
  if (!ok) {
    result.state = CheckState::kFault;
    result.found = std::string("cannot send datagrams of ") + std::to_string(kDatagram_bytes) +
                   " bytes: " + std::strerror(errno);
    result.command = "ip route get " + url.group;
    return result;
  }
  int arrived = 0;
  char first = 0;
  for (pollfd waiting{receiver.handle(), POLLIN, 0};
       arrived < sent && poll(&waiting, 1, kLoopTimeout_ms) > 0; ++arrived) {
    if (recv(receiver.handle(), &first, 1, MSG_DONTWAIT) < 0) break;
  }
  result.found = std::to_string(arrived) + " of " + std::to_string(sent) +
                 " datagrams of a 400 kB message fit the buffer";
  if (arrived < sent) {
    result.state = CheckState::kFault;
    result.command = kMendBuffer;
  }
  return result;
}

}  // namespace fusion_slam
