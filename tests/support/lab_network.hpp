// Several machines of a lab on this one: network namespaces joined by a bridge. All of it belongs
// to this process and its children, and goes with them: nothing of the machine's own network is
// touched.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <sched.h>
#include <unistd.h>

#include "libs/process/child.hpp"

namespace fusion_slam {

class LabNetwork {
 public:
  // Moves this process into a network namespace of its own (call it before there are threads) that
  // holds the bridge, 10.77.0.100, and makes n machines 10.77.0.1 ... n around it. Nothing, and
  // `why`, where that is not permitted.
  static std::optional<LabNetwork> make(int n_machines, std::string* why) {
    if (geteuid() != 0) {
      *why = "network namespaces need root";
      return std::nullopt;
    }
    if (unshare(CLONE_NEWNET) != 0) {
      *why = "this kernel or container permits no network namespaces";
      return std::nullopt;
    }
    LabNetwork network;
    if (!run("ip link set lo up") || !run("ip link add br0 type bridge mcast_snooping 0") ||
        !run("ip addr add 10.77.0.100/24 dev br0") || !run("ip link set br0 up") ||
        !run("ip route add 224.0.0.0/4 dev br0")) {
      *why = "no bridge can be made here";
      return std::nullopt;
    }
    for (int i = 1; i <= n_machines; ++i)
      if (!network.add_machine(i)) {
        *why = "no pair of virtual network devices can be made here";
        return std::nullopt;
      }
    return network;
  }

  // argv that runs on machine i (1, 2 ...); 0: where the bridge is.
  std::vector<std::string> on(int i, std::vector<std::string> argv) const {
    if (i == 0) return argv;
    std::vector<std::string> result{"nsenter", "-t", std::to_string(pid(i)), "-n"};
    result.insert(result.end(), argv.begin(), argv.end());
    return result;
  }

  // What leaves machine i: "loss 5% delay 20ms 5ms reorder 10%". False where the kernel can't.
  bool netem(int i, const std::string& how) const {
    return run("nsenter -t " + std::to_string(pid(i)) +
               " -n tc qdisc replace dev eth0 root netem " + how);
  }
  void perfect(int i) const {
    run("nsenter -t " + std::to_string(pid(i)) + " -n tc qdisc del dev eth0 root");
  }
  // Pulls its cable out, and puts it in again.
  void cut(int i) const { run("ip link set veth" + std::to_string(i) + " down"); }
  void join(int i) const { run("ip link set veth" + std::to_string(i) + " up"); }

 private:
  static bool run(const std::string& command) {
    return std::system((command + " 2>/dev/null").c_str()) == 0;
  }
  pid_t pid(int i) const { return holders_[static_cast<std::size_t>(i - 1)].pid(); }

  bool add_machine(int i) {
    namespace fs = std::filesystem;
    holders_.emplace_back(
        "machine", std::vector<std::string>{"unshare", "--net", "sleep", "100000"}, "/dev/null");
    const std::string process = std::to_string(pid(i));
    const fs::path theirs = "/proc/" + process + "/ns/net";
    std::error_code problem;
    for (int k = 0; k < 2000; ++k) {
      const fs::path there = fs::read_symlink(theirs, problem);
      if (!problem && there != fs::read_symlink("/proc/self/ns/net")) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    const std::string veth = "veth" + std::to_string(i);
    const std::string inside = "nsenter -t " + process + " -n ip ";
    return run("ip link add " + veth + " type veth peer name eth0 netns " + process) &&
           run("ip link set " + veth + " master br0") && run("ip link set " + veth + " up") &&
           run(inside + "link set lo up") &&
           run(inside + "addr add 10.77.0." + std::to_string(i) + "/24 dev eth0") &&
           run(inside + "link set eth0 up") && run(inside + "route add 224.0.0.0/4 dev eth0");
  }

  std::vector<Child> holders_;  // each holds a namespace
};

}  // namespace fusion_slam
