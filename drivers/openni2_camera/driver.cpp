#include "drivers/openni2_camera/driver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>
#include <utility>

namespace fusion_slam {
namespace {

constexpr int kReadMs = 20;
constexpr int kUvcReadMs = 5;
constexpr int kFreshRuntime = 4;                // attempts, then the runtime looks for devices anew
constexpr std::int64_t kReport_us = 1'000'000;  // at most one report of damage in this time

std::int64_t steady_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::int64_t wall_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::string one_digit(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

void set_focal_lengths(const FieldOfView& fov, CameraModel* model) {
  model->fx_px = 0.5 * model->width_px / std::tan(0.5 * fov.x_rad);
  model->fy_px = 0.5 * model->height_px / std::tan(0.5 * fov.y_rad);
  model->cx_px = 0.5 * (model->width_px - 1);
  model->cy_px = 0.5 * (model->height_px - 1);
  model->distortion = {};
}

}  // namespace

CameraSetup setup_for(const OpenniDevice& device, const CameraDriverConfig& config) {
  const CameraConnection& c = config.connection;
  CameraSetup setup;
  setup.model = config.camera;
  if (c.intrinsics == "device") {
    if (device.colour_fov().x_rad <= 0.0)
      throw CameraError(device.name() +
                        " does not say its field of view: set 'intrinsics: file' and the focal "
                        "lengths in the camera's file");
    set_focal_lengths(device.colour_fov(), &setup.model);
  }
  const bool recorded = !config.file.empty() && c.registration == "auto";
  if (device.registers() || c.registration == "none" || recorded) return setup;
  if (!c.T_colour_depth)
    throw CameraError(
        device.name() +
        " does not register depth to colour, and the camera's file does not say where "
        "its depth camera is: add depth_mount_xyz_m_rpy_deg, or 'registration: none'");
  DepthRegistration registration;
  registration.colour_camera = setup.model;
  registration.T_colour_depth = *c.T_colour_depth;
  CameraModel& depth = registration.depth_camera;
  depth = setup.model;
  depth.width_px = device.depth_size().width;
  depth.height_px = device.depth_size().height;
  if (c.depth_fx_px > 0.0) {
    depth.fx_px = c.depth_fx_px;
    depth.fy_px = c.depth_fy_px;
    depth.cx_px = c.depth_cx_px;
    depth.cy_px = c.depth_cy_px;
  } else if (device.depth_fov().x_rad > 0.0) {
    set_focal_lengths(device.depth_fov(), &depth);
  } else {
    throw CameraError(
        device.name() +
        " does not say its depth camera's field of view: add depth_fx_px, depth_fy_px, "
        "depth_cx_px and depth_cy_px to the camera's file");
  }
  setup.registration = registration;
  return setup;
}

struct CameraDriver::Watch {
  explicit Watch(double period_s, Us now_us)
      : pairer(period_s), begin_us(now_us), colour_us(now_us), depth_us(now_us), pair_us(now_us) {}
  // Patience counts from the first frame, which may be long in coming.
  void begin(Us now_us) {
    if (!any) begin_us = colour_us = depth_us = now_us;
    any = true;
  }
  FramePairer pairer;
  Us begin_us, colour_us, depth_us, pair_us;  // when the last one came
  bool any = false;                           // frames came at all
  std::string last_damage;
  int clock_restarts = 0;
};

CameraDriver::CameraDriver(CameraDriverConfig config, CameraEvents events)
    : config_(std::move(config)), events_(std::move(events)) {}

CameraDriver::~CameraDriver() = default;

void CameraDriver::run(const std::atomic<bool>& stop) {
  trouble_since_us_ = steady_us();
  bool ended = false;
  while (!stop && !ended) {
    try {
      open();
      stream(stop);
      ended = !config_.file.empty() && !restart_asked_;
    } catch (const CameraError& error) {
      trouble(error.what(), false);
    }
    restart_asked_ = false;
    uvc_.reset();
    device_.reset();
    if (++failures_ % kFreshRuntime == 0) runtime_.reset();
    if (ended) break;
    for (int waited = 0; waited < config_.retry_ms && !stop; waited += 10)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  runtime_.reset();
  if (ended && !stop && events_.on_end) events_.on_end();
}

void CameraDriver::open() {
  if (!runtime_) runtime_ = std::make_unique<OpenniRuntime>();
  runtime_->clear();
  device_ = std::make_unique<OpenniDevice>(*runtime_, config_);
  const CameraSetup setup = setup_for(*device_, config_);
  if (config_.connection.colour != "openni2") uvc_ = std::make_unique<UvcCamera>(config_);
  clock_ = DeviceClock();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++statistics_.opened;
  }
  if (events_.on_open) events_.on_open(setup);
}

void CameraDriver::stream(const std::atomic<bool>& stop) {
  Watch watch(1.0 / config_.camera.rate_hz, steady_us());
  while (!stop) {
    if (restart_asked_) throw CameraError("restart asked for");
    auto frame = device_->read(uvc_ ? kUvcReadMs : kReadMs);
    const Us now_us = steady_us();
    if (frame) take(std::move(*frame), now_us, &watch);
    if (uvc_) {
      if (auto colour = uvc_->take()) {
        watch.begin(now_us);
        watch.colour_us = now_us;
        emit(watch.pairer.add_colour(std::move(*colour)), now_us, &watch);
      }
    }
    if (recording_ended(now_us, watch)) return;
    supervise(now_us, watch);
  }
}

void CameraDriver::take(DeviceFrame frame, Us now_us, Watch* watch) {
  watch->begin(now_us);
  if (frame.image.empty()) {
    damaged(frame.colour, frame.why, now_us, watch);
    return;
  }
  (frame.colour ? watch->colour_us : watch->depth_us) = now_us;
  const std::int64_t taken_us = clock_.add(frame.device_us, now_us);
  if (clock_.restarts() != watch->clock_restarts) {
    watch->clock_restarts = clock_.restarts();
    trouble("the device's clock jumped; frames are timed by their arrival anew", true);
  }
  TimedImage image{taken_us, std::move(frame.image), frame.device_us};
  emit(frame.colour ? watch->pairer.add_colour(std::move(image))
                    : watch->pairer.add_depth(std::move(image)),
       now_us, watch);
}

void CameraDriver::emit(std::optional<FramePair> pair, Us now_us, Watch* watch) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    statistics_.pairing = watch->pairer.counters();
    statistics_.drift_ppm = clock_.drift_ppm();
  }
  if (!pair) return;
  watch->pair_us = now_us;
  failures_ = 0;
  if (!running_) well(now_us);
  const std::int64_t shift_us =
      wall_us() - steady_us() + std::llround(1e3 * config_.connection.stamp_offset_ms);
  // Two stamps of one clock: what lies between them is known better than when either was.
  if (pair->colour.device_us != 0 && pair->depth.device_us != 0)
    pair->depth.utime_us = pair->colour.utime_us + pair->depth.device_us - pair->colour.device_us;
  pair->colour.utime_us += shift_us;
  pair->depth.utime_us += shift_us;
  if (events_.on_pair) events_.on_pair(std::move(*pair));
}

void CameraDriver::supervise(Us now_us, const Watch& watch) {
  if (runtime_->gone()) throw CameraError(device_->name() + " is gone: unplugged?");
  if (uvc_ && uvc_->broken())
    throw CameraError(config_.connection.colour + " gives no images any more: unplugged?");
  const Us patience_us = 1000LL * (watch.any ? config_.silence_ms : config_.first_frame_ms);
  if (now_us - std::max(watch.pair_us, watch.begin_us) < patience_us) return;
  const std::string ms = std::to_string(patience_us / 1000) + " ms";
  const bool colour = now_us - watch.colour_us < patience_us / 2;
  const bool depth = now_us - watch.depth_us < patience_us / 2;
  if (!watch.last_damage.empty())
    throw CameraError("no whole pair of images for " + ms + ": " + watch.last_damage);
  if (colour && depth)
    throw CameraError("no pair for " + ms + ": colour and depth are never within half a period");
  if (colour) throw CameraError("no depth for " + ms + ", only colour comes");
  if (depth) throw CameraError("no colour for " + ms + ", only depth comes");
  throw CameraError("the camera went silent: nothing for " + ms);
}

// The runtime's file player tells of the end only when it was told not to repeat.
bool CameraDriver::recording_ended(Us now_us, const Watch& watch) const {
  if (config_.file.empty()) return false;
  return runtime_->ended() ||
         (watch.any && !config_.repeat && now_us - watch.pair_us > 1000LL * config_.silence_ms);
}

void CameraDriver::damaged(bool colour, const std::string& why, Us now_us, Watch* watch) {
  watch->last_damage = std::string(colour ? "a colour" : "a depth") + " image was dropped: " + why;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++statistics_.damaged;
  }
  if (!running_ || now_us - last_report_us_ < kReport_us) return;
  last_report_us_ = now_us;
  trouble(watch->last_damage, true);
}

void CameraDriver::trouble(const std::string& why, bool frames) {
  if (!frames && running_) {
    running_ = false;
    trouble_since_us_ = steady_us();
    last_trouble_.clear();
  }
  if (!frames && why == last_trouble_) return;
  if (!frames) last_trouble_ = why;
  if (events_.on_trouble) events_.on_trouble(why, frames);
}

void CameraDriver::well(Us now_us) {
  std::string text = "running: " + device_->name() + ", " + device_->modes();
  if (uvc_) text += ", colour from " + config_.connection.colour;
  if (!last_trouble_.empty())
    text +=
        "; again after " + one_digit(static_cast<double>(now_us - trouble_since_us_) * 1e-6) + " s";
  running_ = true;
  last_trouble_.clear();
  if (events_.on_well) events_.on_well(text);
}

CameraStatistics CameraDriver::statistics() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return statistics_;
}

}  // namespace fusion_slam
