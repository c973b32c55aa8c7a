// Runs shell commands in a network of their own, from which nothing leaves and which nothing
// disturbs.
#pragma once

#include <array>
#include <cstdio>
#include <optional>
#include <string>

#include <sys/wait.h>

namespace fusion_slam {

struct ShellResult {
  int exit_code = -1;
  std::string output;  // stdout and stderr
};

inline ShellResult run_shell(const std::string& command) {
  ShellResult result;
  FILE* pipe = popen(("{ " + command + "\n} 2>&1").c_str(), "r");
  if (pipe == nullptr) return result;
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) result.output += buffer.data();
  const int status = pclose(pipe);
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  return result;
}

// A new network namespace has only a loopback device, which is down. Nothing when this machine
// doesn't permit one. `script` must not hold single quotes.
inline std::optional<ShellResult> in_private_network(const std::string& script) {
  for (const char* const unshare : {"unshare --net", "unshare --user --map-root-user --net"}) {
    if (run_shell(std::string(unshare) + " true").exit_code == 0) {
      return run_shell(std::string(unshare) + " sh -c '" + script + "'");
    }
  }
  return std::nullopt;
}

// What makes LCM work in such a network.
inline std::string with_multicast() {
  return "ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo || exit 99\n";
}

}  // namespace fusion_slam
