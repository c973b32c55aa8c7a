#include "drivers/rplidar/rplidar_process.hpp"

#include <iostream>
#include <stdexcept>
#include <utility>

#include "bot_core/planar_lidar_t.hpp"
#include "drivers/rplidar/resample.hpp"
#include "libs/clock/clock.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

// Nobody maps without ROBOT_MODEL: a camera must not wait for a LiDAR that is not plugged in.
constexpr std::chrono::seconds kWaitForDevice{3};

}  // namespace

RplidarProcess::RplidarProcess(Bus& bus, RobotModel robot, RplidarConfig config)
    : bus_(bus),
      robot_(std::move(robot)),
      start_(std::chrono::steady_clock::now()),
      driver_(std::move(config),
              {[this](const RplidarInfo&, const ScanMode& mode) { on_mode(mode); },
               [this](const Revolution& turn) { on_turn(turn); },
               [this](const std::string& why, bool scans) { on_trouble(why, scans); },
               [this](const std::string& what) { on_well(what); }}) {
  if (bus.mode() != Mode::kLive)
    throw std::runtime_error("a device runs live only; in a replay the log has its LIDAR");
  bus.subscribe<command_t>("COMMAND", Policy::kKeepAll,
                           [this](const command_t& m) { on_command(m); });
  bus.set_state_text("looking for the RPLidar");
  bus.every(1000, [this] { each_second(); });
  reader_ = std::thread([this] { read_device(); });
}

RplidarProcess::~RplidarProcess() {
  stop_ = true;
  reader_.join();
}

void RplidarProcess::read_device() {
  try {
    driver_.run(stop_);
  } catch (...) {
    const std::lock_guard<std::mutex> lock(mutex_);
    failure_ = std::current_exception();
  }
}

void RplidarProcess::on_mode(const ScanMode& mode) {
  const std::lock_guard<std::mutex> lock(mutex_);
  // Listeners hold on to the first ROBOT_MODEL: turns are resampled to what it said.
  if (!announced_) robot_.lidar.beam_period_s = mode.sample_period_s;
}

double RplidarProcess::beam_period_s() {
  const std::lock_guard<std::mutex> lock(mutex_);
  announced_ = true;
  return robot_.lidar.beam_period_s > 0.0 ? robot_.lidar.beam_period_s : 5e-4;
}

void RplidarProcess::on_turn(const Revolution& turn) {
  bus_.publish("LIDAR", to_message(to_laser_scan(turn, beam_period_s())));
}

void RplidarProcess::on_trouble(const std::string& why, bool scans) {
  bus_.report_error(why);
  if (!scans) bus_.set_state_text("no scans: " + why);
}

void RplidarProcess::on_well(const std::string& what) {
  bus_.set_state_text(what);
  std::cerr << "rplidar: " << what << std::endl;
}

void RplidarProcess::each_second() {
  RobotModel robot;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
    const bool waited = std::chrono::steady_clock::now() - start_ > kWaitForDevice;
    if (!announced_ && !waited) return;
    announced_ = true;
    robot = robot_;
  }
  bus_.publish("ROBOT_MODEL", to_message(robot, wall_us()));
}

void RplidarProcess::on_command(const command_t& command) {
  if (command.verb != "reset" || command.target != "rplidar") return;
  driver_.restart();
}

}  // namespace fusion_slam
