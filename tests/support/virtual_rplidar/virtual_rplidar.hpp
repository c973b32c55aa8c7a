// An RPLidar on a pseudo-terminal: answers byte for byte as the device does, measures a
// VirtualWorld at the device's pace, and falls ill on demand. Runs on a thread of its own.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/virtual_rplidar/wire.hpp"
#include "tests/support/virtual_rplidar/world.hpp"

namespace fusion_slam {

enum class VirtualFault {
  kNone,
  kNoise,       // 1 to 8 random bytes between bytes, 30 times a second
  kLoss,        // bytes missing, 30 times a second
  kChecksum,    // a bit of every tenth packet changed (standard: of the check bits)
  kStall,       // neither data nor answers
  kUnplug,      // the port goes; at the end there is a new one behind the same link
  kHealth,      // protection stop: no scan, health 2; at the end it needs a RESET
  kDescriptor,  // stops scanning; answers carry a wrong type
  kSlowMotor,   // 0.8 turns a second
};
// "noise", "loss", ... and back (throws std::invalid_argument).
const char* to_string(VirtualFault fault);
VirtualFault virtual_fault(const std::string& name);
std::vector<VirtualFault> virtual_faults();  // all but kNone

struct VirtualRplidarOptions {
  std::filesystem::path link;  // the port's name: a symbolic link to the pseudo-terminal
  std::string model = "a1";
  VirtualWorld world;
  double rate_hz = 0.0;  // turns a second; 0: the world's
  std::uint32_t seed = 1;
  std::int64_t begin_us = 0;  // utime at which the first turn begins; 0: now
};

class VirtualRplidar {
 public:
  // Throws std::runtime_error when there is no pseudo-terminal or the link can't be made.
  explicit VirtualRplidar(VirtualRplidarOptions options);
  ~VirtualRplidar();  // takes the link away
  VirtualRplidar(const VirtualRplidar&) = delete;
  VirtualRplidar& operator=(const VirtualRplidar&) = delete;

  // From now on; any thread. One fault at a time; returns when it is in force.
  void set_fault(VirtualFault fault);

  bool scanning() const { return scanning_; }
  int motor_pwm() const { return motor_pwm_; }
  std::int64_t bad_requests() const { return bad_requests_; }  // wrong checksum, unknown
  double standard_period_s() const { return standard_period_s_; }

 private:
  using Clock = std::chrono::steady_clock;
  void plug_in();
  void unplug();
  void run();
  void enter_fault(VirtualFault fault);
  void read_requests();
  bool take_request();  // one off the front of in_; false: incomplete
  void answer(std::uint8_t command, const Bytes& payload);
  void answer_conf(const Bytes& payload);
  void send_answer(const Bytes& payload, std::uint8_t type);
  void start_scan(std::uint8_t type);
  void measure();
  wire::Sample next_sample();
  void send_packet(Bytes packet);
  void send(const Bytes& bytes);
  void transmit();      // what the line has carried by now
  double step() const;  // of position_, from sample to sample
  bool once_in(double n) { return std::uniform_real_distribution<>(0.0, n)(random_) < 1.0; }

  VirtualRplidarOptions options_;
  VirtualModel model_;
  std::vector<double> first_sample_;  // of each turn, and the end
  double natural_period_s_ = 5e-4;    // at which each sample of the world is measured once
  double standard_period_s_ = 5e-4;
  std::mt19937 random_;

  std::mutex mutex_;
  std::atomic<VirtualFault> fault_{VirtualFault::kNone};
  int master_ = -1;
  int slave_ = -1;  // held, so that the line does not hang up when the driver closes it
  Bytes in_;
  struct OnTheLine {
    Clock::time_point arrives;
    Bytes bytes;
  };
  std::deque<OnTheLine> out_;
  Clock::time_point line_free_;
  Clock::time_point sending_from_;  // when what is sent next was ready
  std::atomic<bool> scanning_{false};
  std::atomic<int> motor_pwm_{-1};  // -1: turns by itself
  std::atomic<std::int64_t> bad_requests_{0};
  bool protection_stop_ = false;
  std::uint8_t type_ = 0x81;  // of the scan
  double sample_period_s_ = 5e-4;
  double position_ = 0.0;  // in samples of the world
  std::vector<wire::Sample> capsule_;
  bool first_packet_ = true;
  int last_turn_ = -1;
  Clock::time_point measured_until_;
  Clock::time_point boots_until_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace fusion_slam
