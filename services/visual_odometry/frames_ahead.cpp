#include "services/visual_odometry/frames_ahead.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "libs/features/feature_depth.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kMostJobs = 8;  // 2 MB each

}  // namespace

FeatureSet find_features(const OrbExtractor& extractor, const CameraModel& camera,
                         const RgbdFrame& frame) {
  cv::Mat grey;
  cv::cvtColor(frame.colour_bgr, grey, cv::COLOR_BGR2GRAY);
  FeatureSet set = extractor.extract(grey);
  attach_depth(frame.depth_mm, camera, &set);
  undistort(camera, &set);
  return set;
}

bool has_form(const RgbdFrame& frame, const CameraModel& camera) {
  const cv::Size size(camera.width_px, camera.height_px);
  return frame.colour_bgr.type() == CV_8UC3 && frame.depth_mm.type() == CV_16UC1 &&
         frame.colour_bgr.size() == size && frame.depth_mm.size() == size;
}

FramesAhead::FramesAhead(const CameraModel& camera, const OrbConfig& config)
    : camera_(camera), extractor_(config), thread_([this] { work(); }) {}

FramesAhead::~FramesAhead() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void FramesAhead::begin(std::int64_t utime_us, Decode decode) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (jobs_.size() >= kMostJobs) return;
    jobs_.push_back(std::make_shared<Job>());
    jobs_.back()->utime_us = utime_us;
    jobs_.back()->decode = std::move(decode);
  }
  changed_.notify_all();
}

std::optional<SeenFrame> FramesAhead::take(std::int64_t utime_us) {
  std::unique_lock<std::mutex> lock(mutex_);
  const auto it = std::find_if(jobs_.begin(), jobs_.end(),
                               [&](const auto& job) { return job->utime_us == utime_us; });
  if (it == jobs_.end()) return std::nullopt;
  const std::shared_ptr<Job> job = *it;
  jobs_.erase(jobs_.begin(), std::next(it));
  changed_.wait(lock, [&] { return job->state != State::kAtWork; });
  return std::move(job->seen);
}

void FramesAhead::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    const auto waiting = std::find_if(
        jobs_.begin(), jobs_.end(), [](const auto& job) { return job->state == State::kWaiting; });
    if (stopping_) return;
    if (waiting == jobs_.end()) {
      changed_.wait(lock);
      continue;
    }
    const std::shared_ptr<Job> job = *waiting;
    job->state = State::kAtWork;
    lock.unlock();
    std::optional<SeenFrame> seen = see(job->decode);
    lock.lock();
    job->seen = std::move(seen);
    job->state = State::kDone;
    changed_.notify_all();
  }
}

std::optional<SeenFrame> FramesAhead::see(const Decode& decode) const {
  try {
    std::optional<RgbdFrame> frame = decode();
    if (!frame || !has_form(*frame, camera_)) return std::nullopt;
    FeatureSet features = find_features(extractor_, camera_, *frame);
    return SeenFrame{std::move(*frame), std::move(features)};
  } catch (const std::exception&) {
    return std::nullopt;  // whoever needs the frame will meet the same, where it can be reported
  }
}

}  // namespace fusion_slam
