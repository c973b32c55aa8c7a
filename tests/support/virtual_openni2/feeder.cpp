// virtual_openni2: feeds the virtual OpenNI2 device from a log's CAMERA, at its own pace.
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>

#include "bot_core/images_t.hpp"
#include "fusion_slam/camera_model_t.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/eventlog/reader.hpp"
#include "tests/support/virtual_openni2/feed.hpp"

namespace {

using fusion_slam::CameraFault;

std::atomic<bool> stop{false};

struct Feeding {
  std::string log, feed;
  std::vector<std::string> faults;
  std::int64_t begin_us = 0;
  double drift_ppm = 0.0;
};

// "stall@5+2": from second 5, for 2 seconds.
std::map<double, CameraFault> timetable(const std::vector<std::string>& texts) {
  std::map<double, CameraFault> changes;
  for (const std::string& text : texts) {
    const auto at = text.find('@');
    const auto plus = text.find('+');
    std::optional<CameraFault> fault;
    for (const CameraFault f : fusion_slam::camera_faults())
      if (text.substr(0, at) == to_string(f)) fault = f;
    if (!fault || at == std::string::npos || plus == std::string::npos)
      throw std::invalid_argument("'" + text + "' is no fault like stall@5+2");
    const double from_s = std::stod(text.substr(at + 1, plus - at - 1));
    changes[from_s] = *fault;
    changes[from_s + std::stod(text.substr(plus + 1))] = CameraFault::kNone;
  }
  return changes;
}

template <class Message>
bool decode(const fusion_slam::LogEvent& event, Message* message) {
  return message->decode(event.data.data(), 0, static_cast<int>(event.data.size())) >= 0;
}

std::optional<fusion_slam::camera_model_t> find_model(const std::string& log) {
  fusion_slam::LogReader reader(log);
  fusion_slam::camera_model_t model;
  for (fusion_slam::LogEvent event; reader.next(&event);)
    if (event.channel == "CAMERA_MODEL" && decode(event, &model)) return model;
  return std::nullopt;
}

void feed(const Feeding& options) {
  const auto model = find_model(options.log);
  if (!model) throw std::runtime_error(options.log + " has no CAMERA_MODEL");
  fusion_slam::FeedFormat format;
  format.width_px = model->width;
  format.height_px = model->height;
  format.rate_hz = static_cast<int>(std::lround(model->rate_hz));
  format.colour_fx_px = format.depth_fx_px = model->fx;
  format.colour_fy_px = format.depth_fy_px = model->fy;
  fusion_slam::FeedWriter writer(options.feed, format);
  const auto changes = timetable(options.faults);
  auto next = changes.begin();
  const auto wall_us = [] {
    return std::chrono::duration_cast<std::chrono::microseconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
  };
  const std::int64_t begin_us = options.begin_us != 0 ? options.begin_us : wall_us();
  std::optional<std::int64_t> first_us;
  fusion_slam::LogReader reader(options.log);
  std::int64_t frames = 0;
  std::int64_t late = 0;
  for (fusion_slam::LogEvent event; !stop && reader.next(&event);) {
    if (event.channel != "CAMERA") continue;
    bot_core::images_t message;
    std::string why;
    if (!decode(event, &message)) continue;
    const auto frame = fusion_slam::from_message(message, &why);
    if (!frame) continue;
    if (!first_us) first_us = message.utime;
    const std::int64_t at_us = message.utime - *first_us;
    for (; next != changes.end() && next->first * 1e6 <= static_cast<double>(at_us); ++next) {
      writer.set_fault(next->second);
      std::cout << next->first << " s: " << to_string(next->second) << std::endl;
    }
    const std::int64_t wait_us = begin_us + at_us - wall_us();
    if (wait_us < -20'000) ++late;
    if (wait_us > 0) std::this_thread::sleep_for(std::chrono::microseconds(wait_us));
    const auto stamp = [&](std::int64_t utime_us) {
      return static_cast<std::uint64_t>(1e6 + static_cast<double>(utime_us - *first_us) *
                                                  (1.0 + 1e-6 * options.drift_ppm));
    };
    writer.write(stamp(message.utime), stamp(message.images.back().utime), frame->colour_bgr,
                 frame->depth_mm, frame->depth_mm);
    ++frames;
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // the last one is read
  std::cout << frames << " frames given, " << late << " more than 20 ms late" << std::endl;
}

}  // namespace

int main(int argc, char** argv) {
  Feeding options;
  CLI::App app{"virtual_openni2: feeds the virtual OpenNI2 device from a log, at its own pace."};
  app.add_option("--log", options.log, "LCM log with CAMERA")->required()->check(CLI::ExistingFile);
  app.add_option(
         "--feed", options.feed,
         std::string("the feed's file; the driver finds it by ") + fusion_slam::kFeedVariable)
      ->required();
  app.add_option("--begin", options.begin_us, "utime of the first frame (default: now)");
  app.add_option("--drift-ppm", options.drift_ppm, "of the device's clock");
  app.add_option("--fault", options.faults,
                 "NAME@START+SECONDS, again and again: unplug, stall, stall-colour, stall-depth, "
                 "corrupt, wrong-size, clock-restart, busy");
  CLI11_PARSE(app, argc, argv);
  std::signal(SIGINT, [](int) { stop = true; });
  std::signal(SIGTERM, [](int) { stop = true; });
  try {
    feed(options);
  } catch (const std::exception& error) {
    std::cerr << "virtual_openni2: " << error.what() << std::endl;
    return 1;
  }
  return 0;
}
