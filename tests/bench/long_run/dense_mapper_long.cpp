// Does the dense mapper grow with the area or with time? Its library is fed with the keyframes of a
// long drive as fast as it goes; each minute of drive is a line of CSV: memory, processor time a
// keyframe, what a journal written anew would hold, and what a restart from it takes. In the end,
// how good the map is.
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <malloc.h>

#include "bot_core/pose_t.hpp"
#include "fusion_slam/keyframe_image_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/journal/journal.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "services/dense_mapper/dense_mapper.hpp"
#include "tests/bench/dense_map/bench_score.hpp"
#include "tests/support/decoded.hpp"
#include "tests/support/process_meter.hpp"

namespace fusion_slam {
namespace {

constexpr double kKeyframeM = 0.2;  // sensor logs: a keyframe at so much motion
constexpr double kKeyframeRad = 0.2;

class Drive {
 public:
  Drive(double minutes, const DenseMapperConfig& config) : end_minutes_(minutes), config_(config) {
    std::cout << "minute,keyframes,rss_mb,heap_mb,submaps,submaps_mb,base_mb,ms_per_keyframe,"
                 "journalled_mb,kept_mb,restart_ms\n";
  }
  void add_pose(const LogEvent& event) {
    const auto message = decoded<keyframe_t>(event);
    if (const auto T = from_message(message.T_odom_base)) T_map_base_[message.id] = *T;
  }
  void add(const LogEvent& event) {
    std::string why;
    if (event.channel == "CAMERA_MODEL" && !camera_)
      camera_ = from_message(decoded<camera_model_t>(event), &why);
    if (event.channel == "ROBOT_MODEL" && !robot_)
      robot_ = from_message(decoded<robot_model_t>(event), &why);
    if (!mapper_ && camera_ && robot_) {
      mapper_ = std::make_unique<DenseMapper>(*camera_, *robot_, config_);
      mapper_->keep_changes();
    }
    if (event.channel == "KEYFRAME_IMAGE" && mapper_ && !done_)
      map(decoded<keyframe_image_t>(event));
    if (event.channel == "GROUND_TRUTH") {
      const auto message = decoded<bot_core::pose_t>(event);
      if (const auto T = from_message(message)) see(message.utime, *T);
    }
    if (event.channel == "CAMERA" && mapper_ && !done_) image_ = decoded<bot_core::images_t>(event);
    if (image_ && image_->utime == truth_us_) see(truth_us_, truth_);
  }
  bool done() const { return done_; }
  // As a map of the world that begins where the drive began.
  void score(const std::string& path) {
    if (!mapper_ || !robot_) return;
    grid_.take(mapper_->update(true).grid);
    const TruthMap truth = load_truth(path, *robot_, start_.translation().head<2>());
    const MapRaster map = grid_.raster(robot_->map_resolution_m);
    std::cerr << score_line("camera", truth, map, map, SE2{}) << "\n";
    // The graph moves everything by a metre: composed again from what is left of the submaps.
    for (const auto& [id, T] : anchors_)
      mapper_->set_pose(id, from_xyz_rpy(1, 0, 0, 0, 0, 0) * T, truth_us_ + 1'000'000);
    const double begin_ms = process_cpu_ms();
    grid_.take(mapper_->update(true).grid);
    std::cerr << "composed again in " << process_cpu_ms() - begin_ms << " ms\n";
    const MapRaster again = grid_.raster(robot_->map_resolution_m);
    std::cerr << score_line("again", truth, again, again, SE2{-1, 0, 0}) << "\n";
  }

 private:
  // The truth of a moment, and perhaps its image.
  void see(std::int64_t utime_us, const SE3& T_world_base) {
    if (truth_us_ == 0) start_ = T_world_base;
    truth_us_ = utime_us;
    truth_ = T_world_base;
    if (!mapper_ || !image_ || image_->utime != utime_us) return;
    const SE3 moved = keyframe_.inverse() * T_world_base;
    if (id_ == 0 || moved.translation().norm() >= kKeyframeM ||
        log_so3(moved.linear()).norm() >= kKeyframeRad) {
      keyframe_ = T_world_base;
      keyframe_image_t message{};
      message.utime = utime_us;
      message.id = ++id_;
      message.images = *image_;
      T_map_base_ = {{id_, T_world_base}};
      if (id_ % config_.keyframes_per_submap == 1) anchors_[id_] = T_world_base;
      map(message);
    }
    image_.reset();
  }
  void map(const keyframe_image_t& message) {
    const auto pose = T_map_base_.find(message.id);
    std::string why;
    const auto frame = from_message(message.images, &why);
    if (pose == T_map_base_.end() || !frame) return;
    if (begin_us_ == 0) begin_us_ = message.utime;
    const double begin_ms = process_cpu_ms();
    mapper_->add_keyframe(message.id, *frame);
    mapper_->set_pose(message.id, pose->second, message.utime);
    mapper_->integrate_ready();
    const DenseTiles tiles = mapper_->update(false);
    journalled_bytes_ += mapper_->take_changes().size() + event_bytes(message);
    spent_ms_ += process_cpu_ms() - begin_ms;
    ++n_;
    grid_.take(tiles.grid);
    const double minute = 1e-6 / 60.0 * static_cast<double>(message.utime - begin_us_);
    if (minute >= next_minute_) say(minute);
    done_ = minute >= end_minutes_;
  }
  static std::size_t event_bytes(const keyframe_image_t& message) {
    return static_cast<std::size_t>(message.getEncodedSize());
  }
  void say(double minute) {
    next_minute_ += 1.0;
    const double memory_mb = resident_mb();
    const struct mallinfo2 heap = mallinfo2();
    std::vector<SavedBytes> records;
    std::size_t kept_bytes = 0;
    mapper_->write_all([&](const SavedBytes& bytes) {
      kept_bytes += bytes.size();
      records.push_back(bytes);
    });
    const double begin_ms = process_cpu_ms();
    SavedMap map;
    bool good = true;
    for (const SavedBytes& bytes : records)
      good = good && read_saved(bytes.data(), bytes.size(), &map);
    DenseMapper again(*camera_, *robot_, DenseMapperConfig{});
    good = good && again.restore(std::move(map));
    again.update(false);
    const double restart_ms = process_cpu_ms() - begin_ms;
    std::printf("%.2f,%d,%.1f,%.1f,%zu,%.2f,%.2f,%.2f,%.1f,%.2f,%.0f\n", minute, n_, memory_mb,
                1e-6 * static_cast<double>(heap.uordblks + heap.hblkhd), mapper_->submaps(),
                1e-6 * static_cast<double>(mapper_->submap_bytes()),
                1e-6 * static_cast<double>(mapper_->map_bytes()), spent_ms_ / (n_ - said_),
                1e-6 * static_cast<double>(journalled_bytes_),
                1e-6 * static_cast<double>(kept_bytes), good ? restart_ms : -1.0);
    std::fflush(stdout);
    said_ = n_;
    spent_ms_ = 0.0;
  }

  double end_minutes_;
  DenseMapperConfig config_;
  std::map<std::int64_t, SE3> anchors_;  // of a sensor log's submaps
  std::map<std::int64_t, SE3> T_map_base_;
  std::optional<bot_core::images_t> image_;  // of a sensor log, waits for its truth
  std::int64_t truth_us_ = 0;
  std::int64_t id_ = 0;
  SE3 truth_ = SE3::Identity(), start_ = SE3::Identity(), keyframe_ = SE3::Identity();
  HeldGrid grid_;
  std::optional<CameraModel> camera_;
  std::optional<RobotModel> robot_;
  std::unique_ptr<DenseMapper> mapper_;
  std::int64_t begin_us_ = 0;
  std::size_t journalled_bytes_ = 0;
  double spent_ms_ = 0.0;
  double next_minute_ = 1.0;
  int n_ = 0;
  int said_ = 0;
  bool done_ = false;
};

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  CLI::App app(
      "The dense mapper's library on a long drive, a line a minute. Keyframes lie where visual "
      "odometry saw them (KEYFRAME, odom), submaps are superseded as in the service.");
  std::string keyframes;
  std::string images;
  double minutes = 1e9;
  std::string truth;
  app.add_option("keyframes", keyframes,
                 "visual_odometry.lcmlog, a journal; or a sensor log with GROUND_TRUTH: keyframes "
                 "at motion lie where they were")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("images", images, "dense_mapper.lcmlog, a journal with KEYFRAME_IMAGE and models")
      ->check(CLI::ExistingFile);
  fusion_slam::DenseMapperConfig config;
  app.add_option("--more-superseded", config.more_superseded,
                 "submaps looked at for each that closes while they hold too much");
  app.add_option("--truth", truth, "of a sensor log: the world's file, to score the map");
  app.add_option("--minutes", minutes, "of drive, then end");
  CLI11_PARSE(app, argc, argv);
  fusion_slam::Drive drive(minutes, config);
  if (images.empty()) {
    fusion_slam::LogReader reader(keyframes);
    fusion_slam::LogEvent event;
    while (!drive.done() && reader.next(&event)) drive.add(event);
    if (!truth.empty()) drive.score(truth);
    return 0;
  }
  fusion_slam::read_journal(keyframes, [&](const fusion_slam::LogEvent& event) {
    if (event.channel == "KEYFRAME") drive.add_pose(event);
  });
  fusion_slam::read_journal(images, [&](const fusion_slam::LogEvent& event) { drive.add(event); });
  return 0;
}
