// An Ethernet switch in user space, between TAP devices in the namespaces of the lab's machines: it
// loses, delays and reorders frames by seeded chance where the kernel has no netem, and always the
// same way. Frames go through the machines' real IP and UDP stacks.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <map>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace fusion_slam {

struct WireFaults {
  double loss = 0.0;  // share of the frames that leave the machine
  double delay_ms = 0.0;
  double jitter_ms = 0.0;  // evenly in +-: more than the spacing of frames reorders them
};

class UserSwitch {
 public:
  UserSwitch() = default;
  ~UserSwitch() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
    for (const int port : ports_) close(port);
  }
  UserSwitch(const UserSwitch&) = delete;
  UserSwitch& operator=(const UserSwitch&) = delete;

  // Makes the device eth0 in the network namespace of process `pid`; port 0, 1 ... by order of
  // calls. False where that is not permitted. Before start().
  bool plug(pid_t pid) {
    const int ours = open("/proc/self/ns/net", O_RDONLY | O_CLOEXEC);
    const int theirs =
        open(("/proc/" + std::to_string(pid) + "/ns/net").c_str(), O_RDONLY | O_CLOEXEC);
    ifreq request{};
    std::strncpy(request.ifr_name, "eth0", IFNAMSIZ - 1);
    request.ifr_flags = IFF_TAP | IFF_NO_PI;
    bool good = ours >= 0 && theirs >= 0 && setns(theirs, CLONE_NEWNET) == 0;
    // The device belongs to the namespace in which this is opened.
    const int tap = good ? open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC) : -1;
    good = tap >= 0;
    good = good && ioctl(tap, TUNSETIFF, &request) == 0;
    if (ours >= 0 && setns(ours, CLONE_NEWNET) != 0) good = false;
    if (ours >= 0) close(ours);
    if (theirs >= 0) close(theirs);
    if (good) {
      ports_.push_back(tap);
    } else if (tap >= 0) {
      close(tap);
    }
    return good;
  }

  void start() {
    faults_.resize(ports_.size());
    thread_ = std::thread([this] { loop(); });
  }

  void set(std::size_t port, const WireFaults& faults) {
    const std::lock_guard<std::mutex> lock(mutex_);
    faults_[port] = faults;
  }
  // Pulls the cable out (both ways), or puts it in again.
  void cut(std::size_t port, bool is_cut) {
    const std::lock_guard<std::mutex> lock(mutex_);
    cut_[port] = is_cut;
  }
  std::int64_t lost() const { return lost_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Frame {
    std::size_t from = 0;
    std::vector<std::uint8_t> bytes;
  };

  void loop() {
    std::vector<pollfd> polled;
    for (const int port : ports_) polled.push_back({port, POLLIN, 0});
    while (!stopping_) {
      poll(polled.data(), polled.size(), waiting_.empty() ? 20 : 1);
      for (std::size_t port = 0; port < ports_.size(); ++port) take(port);
      while (!waiting_.empty() && waiting_.begin()->first <= Clock::now()) {
        forward(waiting_.begin()->second);
        waiting_.erase(waiting_.begin());
      }
    }
  }

  void take(std::size_t port) {
    std::uint8_t buffer[2048];
    for (ssize_t n = 0; (n = read(ports_[port], buffer, sizeof buffer)) > 0;) {
      const std::lock_guard<std::mutex> lock(mutex_);
      const WireFaults& faults = faults_[port];
      if (cut_[port] || std::uniform_real_distribution<double>(0, 1)(rng_) < faults.loss) {
        ++lost_;
        continue;
      }
      const double delay_ms =
          faults.delay_ms + std::uniform_real_distribution<double>(-1, 1)(rng_) * faults.jitter_ms;
      const auto due = Clock::now() + std::chrono::microseconds(static_cast<int>(1000 * delay_ms));
      waiting_.emplace(due, Frame{port, {buffer, buffer + n}});
    }
  }

  void forward(const Frame& frame) {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (std::size_t port = 0; port < ports_.size(); ++port)
      if (port != frame.from && !cut_[port])
        if (write(ports_[port], frame.bytes.data(), frame.bytes.size()) < 0) ++lost_;
  }

  std::vector<int> ports_;
  std::atomic<bool> stopping_{false};
  std::atomic<std::int64_t> lost_{0};
  std::mutex mutex_;  // of what follows
  std::vector<WireFaults> faults_;
  std::map<std::size_t, bool> cut_;
  std::mt19937 rng_{1};
  std::multimap<Clock::time_point, Frame> waiting_;  // the thread's own
  std::thread thread_;
};

}  // namespace fusion_slam
