// Everything the page shows, fed with the messages of a session in the order they come: from the
// bus, or from a log. Knows the message types but no bus. Any thread: one lock around it; browsers
// read the ItemStore, which has its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "bot_core/images_t.hpp"
#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/command_t.hpp"
#include "fusion_slam/keyframe_image_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/bus/reset_gate.hpp"
#include "libs/procman/lab_config.hpp"
#include "libs/robot/robot_model.hpp"
#include "libs/session/session_collector.hpp"
#include "procman_lcm/deputy_info_t.hpp"
#include "viz/web/graph_view.hpp"
#include "viz/web/grid_view.hpp"
#include "viz/web/health_view.hpp"
#include "viz/web/item_store.hpp"
#include "viz/web/truth_view.hpp"

namespace fusion_slam {

class ViewerState {
 public:
  // The receiver's own time, us since the epoch: the wall clock live; nothing in a replay, whose
  // time is the newest sensor's.
  using Clock = std::function<std::int64_t()>;
  explicit ViewerState(ItemStore& store, Clock clock = {});

  void on(const std::string& channel, const bot_core::images_t& message);
  void on(const std::string& channel, const bot_core::planar_lidar_t& message);
  void on(const std::string& channel, const bot_core::pose_t& message);  // ODOMETRY, GROUND_TRUTH
  void on(const std::string& channel, const camera_model_t& message);
  void on(const std::string& channel, const robot_model_t& message);
  void on(const std::string& channel, const pose_estimate_t& message);
  void on(const std::string& channel, const keyframe_t& message);
  void on(const std::string& channel, const keyframe_image_t& message);
  void on(const std::string& channel, const lidar_node_t& message);
  void on(const std::string& channel, const graph_t& message);
  void on(const std::string& channel, const loop_candidate_t& message);
  void on(const std::string& channel, const constraint_t& message);
  void on(const std::string& channel, const status_t& message);
  void on(const std::string& channel, const procman_lcm::deputy_info_t& message);
  void on(const std::string& channel, const command_t& message);  // reset: the map begins anew
  void on_tile(const std::string& channel, const Tile& tile);

  // Twice a second of real time: what depends on time alone, and the summary of the session.
  void tick();
  // What people may start: a deputy forgets what it was told to stop, and knows nothing at first.
  void set_lab(LabConfig lab);
  // When the session began, where that is known (a recording's index); else its first measurement.
  void begin_at(std::int64_t utime_us);
  // Forgets everything but that; browsers do, too.
  void clear();
  void notice(const std::string& level, const std::string& text);  // info, error; shown for a while
  // Maps and trajectory as `run` leaves them, into a new folder. From any thread; the session goes
  // on meanwhile.
  SessionResult save(const std::filesystem::path& directory) const;

  std::string cell_json(double x_m, double y_m) const;
  std::int64_t session_utime_us() const;  // newest sensor measurement; 0: none yet
  bool has_model() const;

  static constexpr std::int64_t kCameraPeriod_us =
      90'000;  // browsers get every third frame of 30 Hz

 private:
  std::int64_t now_us() const { return clock_ ? clock_() : newest_us_; }
  void note_sensor(const std::string& channel, std::int64_t utime_us, std::size_t size_bytes);
  void put_pose(const std::string& source, std::int64_t utime_us, const SE3& T_map_base, int state,
                const std::string& reason, double sigma_m);
  void put_localization(const pose_estimate_t& message);
  void put_keyframe(std::int64_t id);
  void clear_map();

  struct KeyframeParts {
    std::string features;  // encoded
    std::string jpeg;
    std::int64_t utime_us = 0;
    int width = 0;
    int height = 0;
  };

  ItemStore& store_;
  const Clock clock_;
  LabConfig lab_;
  mutable std::mutex mutex_;
  ResetGate reset_{"viewer"};
  GraphView graph_;
  HealthView health_;
  GridView grid_;
  TruthView truth_;
  std::unique_ptr<SessionCollector> session_;
  std::optional<RobotModel> robot_;
  std::map<std::int64_t, KeyframeParts> keyframes_;  // that wait for their other half; a few
  std::int64_t newest_us_ = 0;
  std::int64_t first_us_ = 0;
  std::int64_t begin_us_ = 0;
  std::int64_t camera_us_ = 0;
  SE3 T_map_base_ = SE3::Identity();
  bool has_pose_ = false;
  bool aligned_ = true;
  double path_m_ = 0.0;
  SE3 T_map_path_ = SE3::Identity();
  std::int64_t notices_ = 0;
  std::size_t damaged_ = 0;
};

}  // namespace fusion_slam
