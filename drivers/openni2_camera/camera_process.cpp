#include "drivers/openni2_camera/camera_process.hpp"

#include <chrono>
#include <cstdio>
#include <iostream>
#include <stdexcept>
#include <utility>

#include "libs/camera_messages/images.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

std::int64_t wall_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

bot_core::images_t to_message(const FramePair& pair, const CameraSetup& setup, int jpeg_quality,
                              ImageCoding coding) {
  RgbdFrame frame;
  frame.utime_us = pair.colour.utime_us;
  frame.colour_bgr = pair.colour.image;
  frame.depth_mm =
      setup.registration ? register_depth(pair.depth.image, *setup.registration) : pair.depth.image;
  bot_core::images_t message = to_message(frame, jpeg_quality, coding);
  message.images[1].utime = pair.depth.utime_us;
  return message;
}

CameraProcess::CameraProcess(Bus& bus, RobotModel robot, CameraDriverConfig config)
    : bus_(bus),
      robot_(std::move(robot)),
      jpeg_quality_(config.connection.jpeg_quality),
      coding_(image_coding(config.connection.images)),
      driver_(std::move(config),
              {[this](const CameraSetup& setup) {
                 const std::lock_guard<std::mutex> lock(mutex_);
                 setup_ = setup;
               },
               [this](FramePair pair) {
                 work_.put({std::move(pair), *setup_});
               },
               [this](const std::string& why, bool frames) { on_trouble(why, frames); },
               [this](const std::string& what) { on_well(what); },
               [this] {
                 std::cerr << "openni2_camera: the recording has ended" << std::endl;
                 bus_.stop();
               }}) {
  if (bus.mode() != Mode::kLive)
    throw std::runtime_error("a device runs live only; in a replay the log has its CAMERA");
  bus.subscribe<command_t>("COMMAND", Policy::kKeepAll,
                           [this](const command_t& m) { on_command(m); });
  bus.set_state_text("looking for the camera");
  bus.every(1000, [this] { each_second(); });
  publisher_ = std::thread([this] { publish(); });
  reader_ = std::thread([this] { read_device(); });
}

CameraProcess::~CameraProcess() {
  stop_ = true;
  reader_.join();
  work_.close();
  publisher_.join();
}

void CameraProcess::keep_failure() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!failure_) failure_ = std::current_exception();
}

void CameraProcess::read_device() {
  try {
    driver_.run(stop_);
  } catch (...) {
    keep_failure();
  }
}

void CameraProcess::publish() {
  try {
    while (const auto work = work_.take())
      bus_.publish("CAMERA", to_message(work->pair, work->setup, jpeg_quality_, coding_));
  } catch (...) {
    keep_failure();
  }
}

void CameraProcess::on_trouble(const std::string& why, bool frames) {
  bus_.report_error(why);
  if (frames) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    well_.clear();
  }
  bus_.set_state_text("no frames: " + why);
}

void CameraProcess::on_well(const std::string& what) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    well_ = what;
    last_pairs_ = 0;
  }
  bus_.set_state_text(what);
  std::cerr << "openni2_camera: " << what << std::endl;
}

void CameraProcess::each_second() {
  const CameraStatistics seen = driver_.statistics();
  std::optional<CameraModel> model;
  std::string text;
  std::int64_t new_pairs = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
    if (setup_) model = setup_->model;
    text = well_;
    new_pairs = seen.pairing.pairs - std::exchange(last_pairs_, seen.pairing.pairs);
  }
  if (model) bus_.publish("CAMERA_MODEL", to_message(*model, wall_us()));
  if (!robot_.has_lidar) bus_.publish("ROBOT_MODEL", to_message(robot_, wall_us()));
  if (text.empty()) return;
  const PairingCounters& p = seen.pairing;
  char numbers[240];
  std::snprintf(
      numbers, sizeof numbers,
      "; %lld pairs in the last second; depth to colour %.1f ms (mean; largest %.1f), alone: "
      "%lld colour, %lld depth; clock %+.0f ppm; %lld damaged, %lld left out under load",
      static_cast<long long>(new_pairs),
      p.pairs > 0 ? 1e-3 * p.sum_error_us / static_cast<double>(p.pairs) : 0.0,
      1e-3 * static_cast<double>(p.largest_error_us), static_cast<long long>(p.colour_alone),
      static_cast<long long>(p.depth_alone), seen.drift_ppm, static_cast<long long>(seen.damaged),
      static_cast<long long>(work_.replaced()));
  bus_.set_state_text(text + numbers);
}

void CameraProcess::on_command(const command_t& command) {
  if (command.verb == "reset" && command.target == "openni2_camera") driver_.restart();
}

}  // namespace fusion_slam
