// Does visual odometry's memory grow with the area or with time? Its library is fed with a long
// drive's sensor log, as fast as it goes; each minute of drive is a line of CSV. The graph is made
// up: every 10 s a loop closure lays all keyframes where GROUND_TRUTH says, between two of them new
// ones hang on odometry. LIDAR_POSE is ODOMETRY. CPU time and memory are this process's.
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>

#include <CLI/CLI.hpp>
#include <malloc.h>
#include <opencv2/core/utility.hpp>

#include "bot_core/images_t.hpp"
#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "services/visual_odometry/visual_odometry.hpp"
#include "tests/support/decoded.hpp"
#include "tests/support/process_meter.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kClosure_us = 10'000'000;

class Bench {
 public:
  Bench(bool with_graph, const VisualOdometryConfig& config)
      : with_graph_(with_graph), config_(config) {
    std::printf(
        "minute,rss_mb,in_use_mb,keyframes,features,landmarks,observations,indexed,cpu_s,lost,"
        "revised,thinned,made,edge_mm,edge_max_mm,edge_mrad\n");
  }

  void on(const LogEvent& event) {
    std::string why;
    if (event.channel == "CAMERA_MODEL" && !camera_)
      camera_ = from_message(decoded<camera_model_t>(event), &why);
    if (event.channel == "ROBOT_MODEL" && !robot_)
      robot_ = from_message(decoded<robot_model_t>(event), &why);
    if (!camera_ || !robot_) return;
    if (!odometry_) odometry_ = std::make_unique<VisualOdometry>(*camera_, *robot_, config_);
    if (event.channel == "ODOMETRY") {
      const auto m = decoded<bot_core::pose_t>(event);
      if (const auto T = from_message(m)) odometry_->add_lidar_pose(m.utime, *T);
    } else if (event.channel == "LIDAR") {
      auto scan = from_message(decoded<bot_core::planar_lidar_t>(event), &why);
      if (scan) odometry_->add_scan(std::move(*scan));
    } else if (event.channel == "GROUND_TRUTH") {
      const auto m = decoded<bot_core::pose_t>(event);
      if (const auto T = from_message(m))
        truth_[m.utime] = *T * robot_->T_base_reference().inverse();
    } else if (event.channel == "CAMERA") {
      if (const auto frame = from_message(decoded<bot_core::images_t>(event), &why)) see(*frame);
    }
  }

  std::int64_t drive_us() const { return last_us_ - begin_us_; }

 private:
  void see(const RgbdFrame& frame) {
    if (begin_us_ == 0) begin_us_ = closed_us_ = frame.utime_us;
    last_us_ = frame.utime_us;
    const TrackingResult result = odometry_->track(frame);
    lost_ += result.state == TrackingState::kLost ? 1 : 0;
    if (result.keyframe) {
      judge(*result.keyframe);
      at_[result.keyframe->id] = frame.utime_us;
      if (with_graph_)
        odometry_->add_graph_node(result.keyframe->id, T_map_odom_ * result.keyframe->T_odom_base);
    }
    if (frame.utime_us - closed_us_ >= kClosure_us) close();
    if (drive_us() >= 60'000'000LL * (minute_ + 1)) line();
  }

  std::optional<SE3> true_pose(std::int64_t utime_us) const {
    const auto after = truth_.lower_bound(utime_us);
    if (after == truth_.begin() || after == truth_.end()) return std::nullopt;
    const auto before = std::prev(after);
    const double share =
        static_cast<double>(utime_us - before->first) / (after->first - before->first);
    return retract(before->second, share * local(before->second, after->second));
  }

  // Edges said since the last line, against the truth.
  void judge(const Keyframe& keyframe) {
    if (keyframe.previous_id != 0)
      edges_.push_back({keyframe.previous_id, keyframe.id, keyframe.T_previous_base});
    std::vector<Edge> later;
    for (const Edge& e : edges_) {
      const auto a = at_.find(e.from), b = at_.find(e.to);
      const auto T_a = a == at_.end() ? std::nullopt : true_pose(a->second);
      const auto T_b = b == at_.end() ? std::nullopt : true_pose(b->second);
      if (!T_a || !T_b) {
        later.push_back(e);
        continue;
      }
      const Vector6d wrong = local(T_a->inverse() * *T_b, e.T_from_to);
      ++n_edges_;
      square_m_ += wrong.head<3>().squaredNorm();
      square_rad_ += wrong.tail<3>().squaredNorm();
      max_m_ = std::max(max_m_, wrong.head<3>().norm());
    }
    edges_ = later;
  }

  void close() {
    closed_us_ = last_us_;
    for (const auto& [id, keyframe] : odometry_->map().keyframes()) {
      const auto T = true_pose(at_.at(id));
      if (!T) continue;
      if (with_graph_) odometry_->add_graph_node(id, *T);
      const SE3 T_odom_base = keyframe.T_odom_camera * robot_->T_base_camera.inverse();
      T_map_odom_ = *T * T_odom_base.inverse();
    }
  }

  void line() {
    ++minute_;
    const VisualMap& map = odometry_->map();
    std::size_t features = 0, observations = 0;
    for (const auto& [id, keyframe] : map.keyframes()) features += keyframe.features->size();
    for (const auto& [id, landmark] : map.landmarks()) observations += landmark.observations.size();
    const VisualOdometryCounts& c = odometry_->counts();
    const double n = std::max(1, n_edges_);
    std::printf("%lld,%.1f,%.1f,%zu,%zu,%zu,%zu,%zu,%.1f,%d,%d,%d,%lld,%.1f,%.1f,%.2f\n",
                static_cast<long long>(minute_), resident_mb(),
                static_cast<double>(mallinfo2().uordblks + mallinfo2().hblkhd) * 1e-6,
                map.keyframes().size(), features, map.landmarks().size(), observations,
                odometry_->places().size(), process_cpu_ms() * 1e-3, lost_, c.revised_keyframes,
                c.keyframes_thinned, static_cast<long long>(at_.empty() ? 0 : at_.rbegin()->first),
                1e3 * std::sqrt(square_m_ / n), 1e3 * max_m_, 1e3 * std::sqrt(square_rad_ / n));
    n_edges_ = 0;
    square_m_ = max_m_ = square_rad_ = 0.0;
    if (minute_ % 10 == 0) malloc_stats();
    std::fflush(stdout);
  }

  bool with_graph_;
  VisualOdometryConfig config_;
  std::optional<CameraModel> camera_;
  std::optional<RobotModel> robot_;
  std::unique_ptr<VisualOdometry> odometry_;
  std::map<std::int64_t, SE3> truth_;        // T_map_base, by utime
  std::map<std::int64_t, std::int64_t> at_;  // utime of each keyframe
  SE3 T_map_odom_ = SE3::Identity();
  struct Edge {
    std::int64_t from = 0, to = 0;
    SE3 T_from_to = SE3::Identity();
  };
  std::vector<Edge> edges_;  // whose truth is not known yet
  int n_edges_ = 0;
  double square_m_ = 0.0, max_m_ = 0.0, square_rad_ = 0.0;
  std::int64_t begin_us_ = 0, last_us_ = 0, closed_us_ = 0, minute_ = 0;
  int lost_ = 0;
};

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  CLI::App app{"Feeds visual odometry's library with a long drive; a line of CSV a minute"};
  std::string log;
  double minutes = 1e9;
  bool with_graph = true;
  app.add_option("LOG", log, "a sensor log with CAMERA and GROUND_TRUTH")->required();
  app.add_option("--minutes", minutes, "stop after so many minutes of drive");
  app.add_flag("!--no-graph", with_graph, "nothing is said about keyframes");
  fusion_slam::VisualOdometryConfig config;
  double thin_age_s = 120.0;
  app.add_option("--thin-age", thin_age_s, "seconds after which a keyframe may be thinned out");
  app.add_option("--thin-m", config.thin_m);
  app.add_option("--thin-cosine", config.thin_cosine);
  app.add_option("--thin-older", config.thin_older);
  app.add_option("--thin-newer", config.thin_newer);
  CLI11_PARSE(app, argc, argv);
  config.thin_age_us = static_cast<std::int64_t>(thin_age_s * 1e6);
  cv::setNumThreads(1);
  fusion_slam::LogReader reader(log);
  fusion_slam::LogEvent event;
  fusion_slam::Bench bench(with_graph, config);
  while (reader.next(&event) && static_cast<double>(bench.drive_us()) <= minutes * 6e7 + 1e5)
    bench.on(event);
  return 0;
}
