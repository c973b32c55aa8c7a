#include "logplayer/loops/read_session.hpp"

#include <optional>
#include <stdexcept>

#include "bot_core/pose_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

template <class Message>
std::optional<Message> decoded(const LogEvent& event) {
  Message message;
  const int size = static_cast<int>(event.data.size());
  if (message.decode(event.data.data(), 0, size) != size) return std::nullopt;
  return message;
}

}  // namespace

LoopReport read_session(const std::filesystem::path& session) {
  LogReader reader(session);
  LogEvent event;
  LoopReport report;
  std::optional<SE3> T_base_reference;
  std::vector<std::pair<std::int64_t, SE3>> truth;
  std::size_t used = 0;
  while (reader.next(&event) || reader.resync()) {
    if (event.channel == "LOOP_CANDIDATE") {
      if (const auto m = decoded<loop_candidate_t>(event)) report.on_candidate(*m), ++used;
    } else if (event.channel == "CONSTRAINT") {
      if (const auto m = decoded<constraint_t>(event)) report.on_constraint(*m), ++used;
    } else if (event.channel == "GRAPH") {
      if (const auto m = decoded<graph_t>(event)) report.on_graph(*m), ++used;
    } else if (event.channel == "KEYFRAME") {
      if (const auto m = decoded<keyframe_t>(event))
        report.on_node({NodeKind::kKeyframe, m->id}, m->utime);
    } else if (event.channel == "LIDAR_NODE") {
      if (const auto m = decoded<lidar_node_t>(event))
        report.on_node({NodeKind::kLidar, m->id}, m->utime);
    } else if (event.channel == "ROBOT_MODEL" && !T_base_reference) {
      std::string why;
      if (const auto m = decoded<robot_model_t>(event))
        if (const auto robot = from_message(*m, &why)) T_base_reference = robot->T_base_reference();
    } else if (event.channel == "GROUND_TRUTH") {
      if (const auto m = decoded<bot_core::pose_t>(event))
        if (const auto T = from_message(*m)) truth.emplace_back(m->utime, *T);
    }
    event.data.clear();
  }
  if (used == 0)
    throw std::runtime_error(session.string() +
                             ": no GRAPH, LOOP_CANDIDATE or CONSTRAINT in it; give the "
                             "session.lcmlog that `fusion-slam run LOG --out DIR` leaves in DIR");
  if (T_base_reference) report.on_robot(*T_base_reference);
  for (const auto& [utime_us, T_world_reference] : truth)
    report.on_truth(utime_us,
                    T_world_reference * T_base_reference.value_or(SE3::Identity()).inverse());
  return report;
}

}  // namespace fusion_slam
