#include "logplayer/report/session_history.hpp"

#include <algorithm>

#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/graph_node_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "fusion_slam/status_t.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

NodeId node_id(std::int8_t kind, std::int64_t id) {
  return {kind == graph_node_t::LIDAR ? NodeKind::kLidar : NodeKind::kKeyframe, id};
}

class Reading {
 public:
  explicit Reading(SessionHistory* history) : history_(*history) {}

  void take(const LogEvent& event) {
    if (event.channel == "STATUS")
      with<status_t>(event, [&](const status_t& m) { on_status(m); });
    else if (event.channel == "KEYFRAME")
      with<keyframe_t>(event, [&](const keyframe_t& m) {
        history_.node_utime_us[{NodeKind::kKeyframe, m.id}] = m.utime;
      });
    else if (event.channel == "LIDAR_NODE")
      with<lidar_node_t>(event, [&](const lidar_node_t& m) {
        history_.node_utime_us[{NodeKind::kLidar, m.id}] = m.utime;
      });
    else if (event.channel == "CONSTRAINT")
      with<constraint_t>(event, [&](const constraint_t& m) {
        history_.loops.push_back(
            {node_id(m.from_kind, m.from_id), node_id(m.to_kind, m.to_id), m.source, false, {}});
      });
    else if (event.channel == "GRAPH")
      with<graph_t>(event, [&](const graph_t& m) {
        if (m.part == 0) off_ = m.switched_off;
      });
    else if (event.channel == "ROBOT_MODEL")
      with<robot_model_t>(event, [&](const robot_model_t& m) {
        if (const auto robot = from_message(m, &why_)) history_.robot = *robot;
      });
    else if (event.channel == "CAMERA_MODEL")
      with<camera_model_t>(event, [&](const camera_model_t& m) {
        if (const auto camera = from_message(m, &why_)) history_.camera = *camera;
      });
  }

  void finish() {
    for (const loop_state_t& off : off_)
      for (ClosedLoop& loop : history_.loops)
        if (loop.from == node_id(off.from_kind, off.from_id) &&
            loop.to == node_id(off.to_kind, off.to_id)) {
          loop.switched_off = true;
          loop.reason = off.reason;
        }
  }

 private:
  template <class Message, class Use>
  static void with(const LogEvent& event, Use use) {
    Message message{};
    const int size = static_cast<int>(event.data.size());
    if (message.decode(event.data.data(), 0, size) == size) use(message);
  }

  void on_status(const status_t& m) {
    if (!start_us_) start_us_ = m.utime;
    history_.health[m.process].push_back({1e-6 * static_cast<double>(m.utime - *start_us_),
                                          m.latency_ms_p95, static_cast<double>(m.peak_rss_bytes),
                                          m.cpu_s, static_cast<double>(m.queue)});
  }

  SessionHistory& history_;
  std::optional<std::int64_t> start_us_;
  std::vector<loop_state_t> off_;
  std::string why_;
};

}  // namespace

SessionHistory read_history(const std::filesystem::path& session) {
  SessionHistory history;
  LogReader reader(session);
  LogEvent event;
  Reading reading(&history);
  while (reader.next(&event) || reader.resync()) {
    reading.take(event);
    event.data.clear();
  }
  reading.finish();
  if (reader.damage()) history.damage = reader.damage()->message;
  for (auto& [process, points] : history.health)
    std::stable_sort(points.begin(), points.end(), [](const HealthPoint& a, const HealthPoint& b) {
      return a.time_s < b.time_s;
    });
  return history;
}

}  // namespace fusion_slam
