// Several machines of a lab on this one: network namespaces joined by a switch. All of it belongs
// to this process and its children, and goes with them: nothing of the machine's own network is
// touched.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <sched.h>
#include <unistd.h>

#include "libs/process/child.hpp"
#include "tests/support/user_switch.hpp"

namespace fusion_slam {

class LabNetwork {
 public:
  // Moves this process into a network namespace of its own (call it before there are threads),
  // machine 0 with 10.77.0.100, and makes n machines 10.77.0.1 ... n beside it. nullptr, and `why`,
  // where that is not permitted.
  static std::unique_ptr<LabNetwork> make(int n_machines, std::string* why) {
    if (geteuid() != 0) {
      *why = "network namespaces need root";
      return nullptr;
    }
    if (unshare(CLONE_NEWNET) != 0) {
      *why = "this kernel or container permits no network namespaces";
      return nullptr;
    }
    std::unique_ptr<LabNetwork> network(new LabNetwork);
    bool good = network->add_device(getpid(), "", 100);
    for (int i = 1; i <= n_machines && good; ++i) good = network->add_machine(i);
    if (!good) {
      *why = "no TAP devices (/dev/net/tun) can be made here";
      return nullptr;
    }
    network->wires_.start();
    return network;
  }

  // argv that runs on machine i.
  std::vector<std::string> on(int i, std::vector<std::string> argv) const {
    if (i == 0) return argv;
    std::vector<std::string> result{"nsenter", "-t", std::to_string(pid(i)), "-n"};
    result.insert(result.end(), argv.begin(), argv.end());
    return result;
  }

  // What happens to frames that leave machine i.
  void disturb(int i, const WireFaults& faults) { wires_.set(static_cast<std::size_t>(i), faults); }
  void cut(int i) { wires_.cut(static_cast<std::size_t>(i), true); }
  void join(int i) { wires_.cut(static_cast<std::size_t>(i), false); }
  std::int64_t lost_frames() const { return wires_.lost(); }

 private:
  LabNetwork() = default;
  pid_t pid(int i) const { return holders_[static_cast<std::size_t>(i - 1)].pid(); }

  bool add_device(pid_t process, const std::string& inside, int last_byte) {
    if (!wires_.plug(process)) return false;
    bool good = true;
    for (const std::string& command :
         {std::string("link set lo up"),
          "addr add 10.77.0." + std::to_string(last_byte) + "/24 dev eth0",
          std::string("link set eth0 up"), std::string("route add 224.0.0.0/4 dev eth0")}) {
      std::string line = inside;
      line.append("ip ").append(command).append(" 2>/dev/null");
      good = std::system(line.c_str()) == 0 && good;
    }
    return good;
  }

  bool add_machine(int i) {
    namespace fs = std::filesystem;
    holders_.emplace_back(
        "machine", std::vector<std::string>{"unshare", "--net", "sleep", "100000"}, "/dev/null");
    const std::string process = std::to_string(pid(i));
    std::error_code problem;
    for (int k = 0; k < 2000; ++k) {  // until it has its namespace
      const fs::path there = fs::read_symlink("/proc/" + process + "/ns/net", problem);
      if (!problem && there != fs::read_symlink("/proc/self/ns/net")) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return add_device(pid(i), "nsenter -t " + process + " -n ", i);
  }

  std::vector<Child> holders_;  // each holds a namespace
  UserSwitch wires_;
};

}  // namespace fusion_slam
