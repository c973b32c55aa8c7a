// What the pose graph's process keeps in its journal, and how it goes on from there.
#include <algorithm>
#include <utility>

#include "fusion_slam/graph_t.hpp"
#include "libs/messages/convert.hpp"
#include "services/pose_graph/graph_messages.hpp"
#include "services/pose_graph/pose_graph_process.hpp"

namespace fusion_slam {
namespace {

constexpr const char* kState = "POSE_GRAPH_STATE";

}  // namespace

void PoseGraphProcess::keep_journal() {
  // What the graph is made of, and where it began anew. Poses, too: they tie keyframes to the
  // LiDAR's trajectory. Written anew the journal has the state instead of all of these.
  bus_.keep_in_journal({"ROBOT_MODEL", "CAMERA_MODEL", "KEYFRAME", "LIDAR_NODE", "CONSTRAINT",
                        "LEVEL", "VISUAL_POSE", "LIDAR_POSE", "ODOMETRY", "COMMAND"});
  bus_.on_note<graph_t>("GRAPH", [this](const graph_t& m) { on_earlier_graph(m); });
  bus_.on_note<constraint_t>("RETIRED", [this](const constraint_t& m) {
    if (const auto retirement = retirement_from(m)) earlier_.retired[m.seq].push_back(*retirement);
  });
  bus_.on_note<journal_note_t>(kState, [this](const journal_note_t& m) {
    saved_ = m.data;
    earlier_ = {};  // it is in the state
  });
  Bus::JournalNeeds needs;
  needs.first_of = {"CAMERA_MODEL", "ROBOT_MODEL"};
  needs.note_state = [this] { write_down(); };
  bus_.keep_journal_small(std::move(needs));
}

void PoseGraphProcess::on_earlier_graph(const graph_t& message) {
  earlier_revision_ = std::max(earlier_revision_, message.revision);
  for (const graph_node_t& node : message.nodes)
    if (const auto T_map_base = from_message(node.T_map_base);
        T_map_base && is_node_kind(node.kind))
      earlier_.T_map_base[{static_cast<NodeKind>(node.kind), node.id}] = *T_map_base;
  if (message.part != 0) return;
  earlier_.switched_off.clear();
  for (const loop_state_t& loop : message.switched_off)
    if (is_node_kind(loop.from_kind) && is_node_kind(loop.to_kind))
      earlier_.switched_off.push_back(state_from(loop));
}

void PoseGraphProcess::write_down() {
  journal_note_t message{};
  NoteWriter out(&message.data);
  out.put(revision());
  out.put(reset_.border_us());
  for (const NodeKind sensor : {NodeKind::kKeyframe, NodeKind::kLidar}) clock_[sensor].write(&out);
  graph_.write(&out);
  message.size_bytes = static_cast<std::int32_t>(message.data.size());
  bus_.note(kState, message);
}

void PoseGraphProcess::restore_state() {
  const std::vector<std::uint8_t> saved = std::exchange(saved_, {});
  NoteReader in(saved.data(), saved.size());
  earlier_revision_ = std::max(earlier_revision_, in.get<std::int64_t>());
  reset_.restore(in.get<std::int64_t>());
  for (const NodeKind sensor : {NodeKind::kKeyframe, NodeKind::kLidar}) clock_[sensor].read(&in);
  if (!graph_.restore(&in))
    bus_.report_error(
        "the journal's state is damaged or of another version: the map begins anew with what was "
        "measured since it was written");
  say_state();
}

// The journal gives first the state and where an earlier process had its nodes since, then what
// that was told since. There need not be anything of these.
void PoseGraphProcess::follow_recovery() {
  if (!saved_.empty()) restore_state();
  const bool begins = bus_.recovering() && !std::exchange(rebuild_begun_, true);
  if (begins || !earlier_.T_map_base.empty()) graph_.rebuild(std::exchange(earlier_, {}));
  if (!bus_.recovering()) graph_.rebuilt();
}

}  // namespace fusion_slam
