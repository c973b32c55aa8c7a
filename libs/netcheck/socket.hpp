// A UDP socket that closes itself, set up as LCM sets up its own.
#pragma once

#include <cstdint>
#include <string>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace fusion_slam {

class UdpSocket {
 public:
  UdpSocket() : handle_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~UdpSocket() {
    if (handle_ >= 0) close(handle_);
  }
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  int handle() const { return handle_; }

  template <class Value>
  bool set(int level, int option, const Value& value) {
    return setsockopt(handle_, level, option, &value, sizeof value) == 0;
  }

  int get_int(int level, int option) const {
    int value = 0;
    socklen_t size = sizeof value;
    return getsockopt(handle_, level, option, &value, &size) == 0 ? value : -1;
  }

  // Receives what is sent to group:port (0: a free port).
  bool join(const std::string& group, std::uint16_t port);
  std::uint16_t port() const;

 private:
  int handle_;
};

inline sockaddr_in socket_address(const std::string& ip, std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  inet_pton(AF_INET, ip.c_str(), &address.sin_addr);
  return address;
}

inline bool UdpSocket::join(const std::string& group, std::uint16_t port) {
  const int yes = 1;
  const sockaddr_in any = socket_address("0.0.0.0", port);
  ip_mreq membership{};
  membership.imr_multiaddr = socket_address(group, 0).sin_addr;
  return set(SOL_SOCKET, SO_REUSEADDR, yes) && set(SOL_SOCKET, SO_REUSEPORT, yes) &&
         bind(handle_, reinterpret_cast<const sockaddr*>(&any), sizeof any) == 0 &&
         set(IPPROTO_IP, IP_ADD_MEMBERSHIP, membership);
}

inline std::uint16_t UdpSocket::port() const {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  return getsockname(handle_, reinterpret_cast<sockaddr*>(&address), &size) == 0
             ? ntohs(address.sin_port)
             : 0;
}

}  // namespace fusion_slam
