// The health of every process and input, from STATUS and from what arrives: rates, latency, losses,
// who is late and by how much. Items of Topic::kHealth and kInput. `now_us` is the receiver's own
// time: the wall clock live, the session's time in a replay. Not thread-safe.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>

#include "fusion_slam/status_t.hpp"
#include "viz/web/item_store.hpp"

namespace fusion_slam {

class HealthView {
 public:
  explicit HealthView(ItemStore& store) : store_(store) {}

  void on_status(const status_t& message, std::int64_t now_us);
  // A sensor's message: CAMERA, LIDAR, ODOMETRY; and POSE.
  void on_input(const std::string& channel, std::int64_t utime_us, std::size_t size_bytes,
                std::int64_t now_us);
  // Brings what depends on the time alone up to date: a silent input gets later, a process that
  // says nothing is gone. To be called about twice a second of now_us.
  void tick(std::int64_t now_us);
  void clear();

  // An input is late when it is this many of its own periods, and half a second, behind.
  static constexpr double kLatePeriods = 5.0;
  static constexpr std::int64_t kLateAtLeast_us = 500'000;
  static constexpr std::int64_t kSilent_us = 5'000'000;  // a process says STATUS once a second

 private:
  struct Process {
    status_t status;
    std::int64_t heard_us = 0;
    std::int64_t processed = 0;  // over all channels it listens to
    double rate_hz = 0.0;        // messages handled a second
    double cpu_percent = 0.0;
  };
  struct Input {
    std::int64_t utime_us = 0;
    std::int64_t heard_us = 0;
    std::deque<std::pair<std::int64_t, std::size_t>> recent;  // utime, bytes; some seconds of it
  };
  void put(const std::string& name, const Process& process, std::int64_t now_us);
  void put(const std::string& channel, const Input& input, std::int64_t now_us);
  std::int64_t newest_input_us() const;

  ItemStore& store_;
  std::map<std::string, Process> processes_;
  std::map<std::string, Input> inputs_;
};

}  // namespace fusion_slam
