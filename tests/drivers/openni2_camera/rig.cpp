#include "tests/drivers/openni2_camera/rig.hpp"

#include <cstdlib>
#include <iostream>
#include <stdexcept>
#include <utility>

namespace fusion_slam {
namespace {

constexpr double kWall_m = 2.0;
constexpr double kBox_m = 1.0;
constexpr double kBoxHalf_m = 0.15;

double depth_at(double x_per_z, double y_per_z, double camera_x_m) {
  const double x_m = camera_x_m + x_per_z * kBox_m;
  const bool box = std::abs(x_m) < kBoxHalf_m && std::abs(y_per_z * kBox_m) < kBoxHalf_m;
  return box ? kBox_m : kWall_m;
}

cv::Mat depth_image(const FeedFormat& f, double fx_px, double fy_px, double camera_x_m) {
  cv::Mat depth(f.height_px, f.width_px, CV_16UC1);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u)
      depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(
          1e3 * depth_at((u - 0.5 * (f.width_px - 1)) / fx_px,
                         (v - 0.5 * (f.height_px - 1)) / fy_px, camera_x_m));
  return depth;
}

}  // namespace

FeedFormat rig_format() {
  FeedFormat format;
  format.width_px = 160;
  format.height_px = 120;
  format.colour_fx_px = format.colour_fy_px = 140.0;
  format.depth_fx_px = format.depth_fy_px = 150.0;
  return format;
}

RigScene rig_scene(const FeedFormat& format) {
  RigScene scene;
  scene.depth_mm = depth_image(format, format.depth_fx_px, format.depth_fy_px, kRigBaseline_m);
  scene.registered_mm = depth_image(format, format.colour_fx_px, format.colour_fy_px, 0.0);
  scene.colour_bgr.create(format.height_px, format.width_px, CV_8UC3);
  for (int v = 0; v < format.height_px; ++v)
    for (int u = 0; u < format.width_px; ++u)
      scene.colour_bgr.at<cv::Vec3b>(v, u) =
          cv::Vec3b(static_cast<std::uint8_t>(u), static_cast<std::uint8_t>(v),
                    scene.registered_mm.at<std::uint16_t>(v, u) < 1500 ? 200 : 20);
  return scene;
}

CameraRig::CameraRig(const FeedFormat& format) : format_(format), scene_(rig_scene(format)) {
  std::string name = (std::filesystem::temp_directory_path() / "openni2-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
  folder_ = name;
  setenv(kFeedVariable, (folder_ / "feed").c_str(), 1);
  CameraModel& camera = config_.camera;
  camera.width_px = format.width_px;
  camera.height_px = format.height_px;
  camera.fx_px = format.colour_fx_px;
  camera.fy_px = format.colour_fy_px;
  camera.cx_px = 0.5 * (format.width_px - 1);
  camera.cy_px = 0.5 * (format.height_px - 1);
  camera.rate_hz = format.rate_hz;
}

CameraRig::~CameraRig() {
  stop();
  unplug();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void CameraRig::plug_in() {
  feed_ = std::make_unique<FeedWriter>(folder_ / "feed", format_);
  feeding_ = true;
  feeder_ = std::thread([this] { give_frames(); });
}

void CameraRig::unplug() {
  feeding_ = false;
  if (feeder_.joinable()) feeder_.join();
  feed_.reset();
}

void CameraRig::give_frames() {
  const auto begin = std::chrono::steady_clock::now();
  const auto period = std::chrono::microseconds(1'000'000 / format_.rate_hz);
  for (std::int64_t i = 1; feeding_; ++i) {
    std::this_thread::sleep_until(begin + i * period);
    const auto stamp = static_cast<std::uint64_t>(i * period.count());
    feed_->write(stamp, stamp + static_cast<std::uint64_t>(depth_lag_us_.load()), scene_.colour_bgr,
                 scene_.depth_mm, scene_.registered_mm);
  }
}

void CameraRig::start() {
  CameraEvents events;
  events.on_open = [this](const CameraSetup& setup) {
    const std::lock_guard<std::mutex> lock(mutex_);
    setup_ = setup;
  };
  events.on_pair = [this](FramePair pair) { add({{}, "", true, std::move(pair)}); };
  events.on_trouble = [this](const std::string& why, bool frames) { add({{}, why, frames, {}}); };
  events.on_well = [this](const std::string& what) { add({{}, what, true, {}}); };
  events.on_end = [this] { ended_ = true; };
  driver_ = std::make_unique<CameraDriver>(config_, events);
  stop_ = false;
  thread_ = std::thread([this] { driver_->run(stop_); });
}

void CameraRig::stop() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void CameraRig::add(Entry entry) {
  entry.when = std::chrono::steady_clock::now();
  const std::lock_guard<std::mutex> lock(mutex_);
  diary_.push_back(std::move(entry));
  changed_.notify_all();
}

CameraRig::Diary CameraRig::diary() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return diary_;
}

std::optional<CameraSetup> CameraRig::setup() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return setup_;
}

bool CameraRig::wait(const std::function<bool(const Diary&)>& done) {
  std::unique_lock<std::mutex> lock(mutex_);
  if (changed_.wait_for(lock, std::chrono::seconds(30), [&] { return done(diary_); })) return true;
  for (const Entry& entry : diary_)
    if (!entry.text.empty()) std::cerr << "the driver said: " << entry.text << "\n";
  return false;
}

bool CameraRig::wait_for_text(const std::string& part, std::size_t from) {
  return wait([&](const Diary& diary) {
    for (std::size_t i = from; i < diary.size(); ++i)
      if (diary[i].text.find(part) != std::string::npos) return true;
    return false;
  });
}

bool CameraRig::wait_for_pairs(int n, std::size_t from) {
  return wait([&](const Diary& diary) {
    int pairs = 0;
    for (std::size_t i = from; i < diary.size(); ++i) pairs += diary[i].text.empty() ? 1 : 0;
    return pairs >= n;
  });
}

}  // namespace fusion_slam
