#include "logplayer/map_merge/merge.hpp"

#include <algorithm>
#include <stdexcept>

#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/keyframe_image_t.hpp"
#include "libs/map_directory/decode.hpp"
#include "libs/map_directory/map_saver.hpp"
#include "libs/messages/convert.hpp"
#include "libs/schema/guard.hpp"
#include "logplayer/map_merge/join.hpp"
#include "logplayer/map_merge/joint_graph.hpp"
#include "logplayer/map_merge/recompose.hpp"
#include "logplayer/map_merge/renumber.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kPauseUs = 60'000'000;  // between two sessions whose times overlap
constexpr std::size_t kFewestLoops = 3;

using TimedEvents = std::vector<std::pair<std::int64_t, LogEvent>>;

template <class Message>
LogEvent event_of(std::int64_t utime_us, const char* channel, const Message& message) {
  LogEvent event;
  event.timestamp_us = utime_us;
  event.channel = channel;
  event.data.resize(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(event.data.data(), 0, static_cast<int>(event.data.size()));
  return event;
}

// What was said as history; state (GRAPH, tiles but SUBMAP) is made anew.
bool is_history(const std::string& channel) {
  return is_journal_channel(channel) && channel != "GRAPH" && channel != "ROBOT_MODEL" &&
         channel != "CAMERA_MODEL" && channel != "OCTOMAP" && channel != "CLOUD" &&
         channel.rfind("GRID_", 0) != 0;
}

TimedEvents history(const MapReader& map, const Offsets& offsets) {
  TimedEvents events;
  map.for_each([&](const LogEvent& event) {
    if (!is_history(event.channel)) return;
    LogEvent moved = renumbered(event, offsets);
    const auto utime_us = peek_utime(moved.data.data(), moved.data.size());
    events.emplace_back(utime_us.value_or(moved.timestamp_us), std::move(moved));
  });
  std::stable_sort(events.begin(), events.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  return events;
}

Offsets offsets_after(const MapReader& first, const MapSummary& second) {
  Offsets offsets;
  first.for_each([&](const LogEvent& event) { note_largest(event, &offsets); });
  const std::int64_t end_us = first.summary().last_utime_us;
  if (second.first_utime_us <= end_us) offsets.time_us = end_us + kPauseUs - second.first_utime_us;
  return offsets;
}

// The newest node of a kind.
std::optional<NodeId> last_of(NodeKind kind, const SessionGraph& graph) {
  std::optional<NodeId> last;
  for (const auto& [id, node] : graph.nodes())
    if (id.kind == kind) last = id;
  return last;
}

std::optional<NodeId> first_of(NodeKind kind, const SessionGraph& graph) {
  for (const auto& [id, node] : graph.nodes())
    if (id.kind == kind) return id;
  return std::nullopt;
}

// Each of the second session's tracks starts where the first proven place puts it.
void start_tracks(const MapState& first, const MapState& second, const MapFix& proven,
                  JointGraph* graph) {
  const auto T_first_nodes = first.graph.T_map_nodes(), T_second_nodes = second.graph.T_map_nodes();
  const auto node = T_second_nodes.find(proven.node);
  if (node == T_second_nodes.end()) return;
  const SE3 T_first_second = proven.where.T_map_base * node->second.inverse();
  for (const NodeKind kind : {NodeKind::kKeyframe, NodeKind::kLidar}) {
    const auto last = last_of(kind, first.graph), begin = first_of(kind, second.graph);
    if (last && begin)
      graph->start_track_at(
          kind, *last,
          T_first_nodes.at(*last).inverse() * T_first_second * T_second_nodes.at(*begin));
  }
}

constraint_t message_of(const CrossLoop& loop, std::int64_t utime_us, std::int64_t seq) {
  constraint_t message{};
  message.utime = utime_us;
  message.seq = seq;
  message.from_kind = static_cast<std::int8_t>(loop.from.kind);
  message.from_id = loop.from.id;
  message.to_kind = static_cast<std::int8_t>(loop.to.kind);
  message.to_id = loop.to.id;
  message.T_from_to = to_message(loop.T_from_to, utime_us);
  to_message(loop.covariance, message.covariance);
  message.source = "join of two sessions";
  return message;
}

graph_t graph_message(const JointGraph& graph) {
  graph_t message{};
  message.revision = 1;
  message.complete = 1;
  message.n_parts = 1;
  message.n_loops = static_cast<std::int32_t>(graph.loops());
  for (const auto& [id, node] : graph.nodes()) {
    graph_node_t out{};
    out.kind = static_cast<std::int8_t>(id.kind);
    out.id = id.id;
    out.utime = node.utime_us;
    out.T_map_base = to_message(node.T_map_base, node.utime_us);
    message.utime = std::max(message.utime, node.utime_us);
    message.nodes.push_back(out);
  }
  message.n_nodes = static_cast<std::int32_t>(message.nodes.size());
  return message;
}

void check_alike(const MapState& a, const MapState& b) {
  if (a.robot.map_resolution_m != b.robot.map_resolution_m)
    throw std::runtime_error("the two maps have cells of different size (" +
                             std::to_string(a.robot.map_resolution_m) + " and " +
                             std::to_string(b.robot.map_resolution_m) +
                             " m): record one of them again with the other's map_resolution_m");
}

}  // namespace

MergeReport merge_maps(const std::filesystem::path& first_directory,
                       const std::filesystem::path& second_directory,
                       const std::filesystem::path& out) {
  check_is_map_or_nothing(out);
  const MapReader first(first_directory), second(second_directory);
  const MapState first_state = read_state(first), second_state = read_state(second);
  check_alike(first_state, second_state);

  const Join join = find_join(first, first_state, second, second_state.robot);
  std::vector<CrossLoop> loops = cross_loops(join.fixes, first_state.graph.T_map_nodes());
  if (loops.size() < kFewestLoops)
    throw std::runtime_error("no overlap is proven between " + first_directory.string() + " and " +
                             second_directory.string() + ": " +
                             (join.fixes.empty() ? join.reason : "too short a way in common") +
                             ". Drive through a part of the first map for some metres");

  MergeReport report;
  const Offsets offsets = offsets_after(first, second.summary());
  report.shifted_s = 1e-6 * static_cast<double>(offsets.time_us);
  TimedEvents events = history(first, Offsets{});
  const std::size_t n_first = events.size();
  for (auto& event : history(second, offsets)) events.push_back(std::move(event));

  JointGraph graph(first_state.robot);
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (i == n_first) start_tracks(first_state, second_state, join.fixes.front(), &graph);
    if (i >= n_first && events[i].second.channel == "LEVEL") continue;  // the first's is level
    graph.add(events[i].second);
  }
  std::int64_t seq = offsets.seq.count("CONSTRAINT") > 0 ? offsets.seq.at("CONSTRAINT") : 0;
  second.for_each([&](const LogEvent& event) { seq += event.channel == "CONSTRAINT" ? 1 : 0; });
  const std::int64_t end_us = events.back().first;
  for (CrossLoop& loop : loops) {
    loop.to = offsets.moved(loop.to);
    graph.add_loop(loop.from, loop.to, loop.T_from_to, loop.covariance);
    events.emplace_back(end_us, event_of(end_us, "CONSTRAINT", message_of(loop, end_us, ++seq)));
  }
  graph.finish();
  for (const LoopState& off : graph.switched_off())
    for (const CrossLoop& loop : loops)
      report.switched_off += off.from == loop.from && off.to == loop.to ? 1 : 0;
  report.cross_loops = static_cast<std::int64_t>(loops.size());
  if (2 * report.switched_off > report.cross_loops)
    throw std::runtime_error(
        "no overlap is proven: the closures between the two maps contradict "
        "what was measured within them");

  MapSaveOptions save;
  save.sessions = first.summary().sessions + second.summary().sessions;
  MapSaver saver(out, save);
  RobotModel robot = first_state.robot;
  robot.has_lidar = robot.has_lidar || second_state.robot.has_lidar;
  robot.has_camera = robot.has_camera || second_state.robot.has_camera;
  saver.add(event_of(0, "ROBOT_MODEL", to_message(robot, end_us)));
  const auto& camera = first_state.camera_message ? first_state : second_state;
  if (camera.camera_message) saver.add(event_of(0, "CAMERA_MODEL", *camera.camera_message));
  Recomposer recomposer(robot, camera.camera);
  for (const auto& [utime_us, event] : events) {
    saver.add(event);
    if (event.channel == "SUBMAP") {
      if (const auto tile = decode<tile_t>(event)) recomposer.add_submap_tile(from_message(*tile));
    } else if (event.channel == "KEYFRAME_IMAGE") {
      if (const auto image = decode<keyframe_image_t>(event)) recomposer.add_image(*image);
    }
  }
  if (const auto wish = recomposer.place(graph.nodes()))
    graph.level({NodeKind::kKeyframe, wish->anchor_id}, wish->T_level_anchor);
  for (const auto& [channel, tiles] : recomposer.compose(graph.nodes()))
    for (const Tile& tile : tiles) saver.add(event_of(end_us, channel.c_str(), to_message(tile)));
  saver.add(event_of(end_us, "GRAPH", graph_message(graph)));
  report.images_refused = recomposer.images_refused();
  report.summary = saver.finish();
  return report;
}

}  // namespace fusion_slam
