// What the pose graph writes down of itself, so that a restart need not read the whole journal:
// docs/formats.md has the bytes. Poses that wait for their node aren't in it.
#include <algorithm>
#include <utility>

#include "services/pose_graph/note_parts.hpp"
#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {
namespace {

constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kManyNodes = 200;  // a solve of fewer takes milliseconds

}  // namespace

void PoseGraph::write(NoteWriter* out) const {
  out->put(kVersion);
  const PoseGraphCounts& c = counts_;
  for (const std::int64_t n :
       {c.solves, c.loops, c.loops_outvoted, c.loops_switched_off, c.ties, c.edges_doubted,
        c.bundles, c.bundles_refused, c.restarts, c.levellings, c.retired, c.rejected,
        newest_utime_us_, n_placed_, next_thinning_, static_cast<std::int64_t>(unsolved_loops_),
        static_cast<std::int64_t>(new_visual_loops_),
        static_cast<std::int64_t>(bundled_keyframes_)})
    out->put(n);
  write_nodes(out);
  write_retired(out);
  out->count(switched_off_.size());
  for (const LoopState& loop : switched_off_) put_loop_state(loop, out);
  seen_.write(out);
  out->count(same_points_.size());
  for (const auto& [ends, pairs] : same_points_) {
    put_node(ends.first, out);
    put_node(ends.second, out);
    put_pairs(pairs, out);
  }
  for (const PoseTrack* track : {&visual_, &lidar_, &odometry_}) track->write(out);
  out->count(waiting_nodes_.size());
  for (const auto& [key, node] : waiting_nodes_) put_node_input(node, out);
  out->count(waiting_ties_.size());
  for (const auto& [utime_us, id] : waiting_ties_) {
    out->put(utime_us);
    put_node(id, out);
  }
  out->count(waiting_loops_.size());
  for (const LoopInput& loop : waiting_loops_) put_loop_input(loop, out);
}

void PoseGraph::write_nodes(NoteWriter* out) const {
  out->count(nodes_.size());
  for (const auto& [id, node] : nodes_) {
    put_node(id, out);
    out->put(node.utime_us);
    out->pose(node.T_map_base);
    out->pose(node.T_odom_base);
  }
  out->count(edges_.size());
  for (const GraphEdge& edge : edges_) put_edge(edge, out);
  out->count(doubted_.size());
  for (const auto& [edge, times] : doubted_) {
    out->put(static_cast<std::uint32_t>(edge));
    out->put(static_cast<std::int32_t>(times));
  }
}

void PoseGraph::write_retired(NoteWriter* out) const {
  out->count(retired_.size());
  for (const auto& [id, retired] : retired_) {
    put_node(id, out);
    out->put(retired.utime_us);
    put_node(retired.carrier, out);
    out->vector(retired.t_carrier_base_m);
    for (const double x : retired.q_carrier_base.coeffs()) out->put(x);
    out->put(retired.translation_m2);
    out->put(retired.rotation_rad2);
  }
}

// What refers to a node that isn't there makes it worthless.
bool PoseGraph::read(NoteReader* in) {
  bool good = in->get<std::uint8_t>() == kVersion;
  PoseGraphCounts& c = counts_;
  std::int64_t unsolved = 0, visual_loops = 0, bundled = 0;
  for (std::int64_t* n :
       {&c.solves, &c.loops, &c.loops_outvoted, &c.loops_switched_off, &c.ties, &c.edges_doubted,
        &c.bundles, &c.bundles_refused, &c.restarts, &c.levellings, &c.retired, &c.rejected,
        &newest_utime_us_, &n_placed_, &next_thinning_, &unsolved, &visual_loops, &bundled})
    *n = in->get<std::int64_t>();
  unsolved_loops_ = static_cast<int>(std::clamp<std::int64_t>(unsolved, 0, 1 << 20));
  new_visual_loops_ = static_cast<int>(std::clamp<std::int64_t>(visual_loops, 0, 1 << 20));
  bundled_keyframes_ = static_cast<std::size_t>(std::max<std::int64_t>(0, bundled));
  good = good && read_nodes(in) && read_retired(in);
  for (std::size_t n = in->count(2 * kNodeIdBytes + 12); n > 0; --n)
    switched_off_.push_back(get_loop_state(in));
  seen_.read(in);
  for (std::size_t n = in->count(2 * kNodeIdBytes + 4); n > 0; --n) {
    const NodeId from = get_node(in);
    const NodeId to = get_node(in);
    same_points_[{from, to}] = get_pairs(in);
  }
  for (PoseTrack* track : {&visual_, &lidar_, &odometry_}) track->read(in);
  for (std::size_t n = in->count(kNodeInputBytes); n > 0; --n) {
    NodeInput node = get_node_input(in);
    if (!known(node.id)) waiting_nodes_[{node.utime_us, node.id}] = std::move(node);
  }
  for (std::size_t n = in->count(8 + kNodeIdBytes); n > 0; --n) {
    const auto utime_us = in->get<std::int64_t>();
    waiting_ties_.emplace(utime_us, get_node(in));
  }
  for (std::size_t n = in->count(kLoopInputBytes); n > 0; --n)
    waiting_loops_.push_back(get_loop_input(in));
  for (const auto& [utime_us, id] : waiting_ties_) good = good && known(id);
  taken_ = nodes_;
  return good && in->good() && !in->more();
}

bool PoseGraph::read_nodes(NoteReader* in) {
  for (std::size_t n = in->count(kNodeIdBytes + 8 + 2 * kPoseBytes); n > 0; --n) {
    const NodeId id = get_node(in);
    GraphNode& node = nodes_[id];
    node.utime_us = in->get<std::int64_t>();
    node.T_map_base = in->pose();
    node.T_odom_base = in->pose();
    by_time_.emplace(node.utime_us, id);
  }
  bool good = by_time_.size() == nodes_.size();
  for (std::size_t n = in->count(kEdgeBytes); n > 0 && good; --n) {
    const auto edge = get_edge(in);
    good = edge && nodes_.count(edge->from) > 0 && nodes_.count(edge->to) > 0 &&
           edge->from != edge->to;
    if (good) edges_.push_back(*edge);
  }
  for (std::size_t n = good ? in->count(8) : 0; n > 0 && good; --n) {
    const auto edge = in->get<std::uint32_t>();
    doubted_[edge] = in->get<std::int32_t>();
    good = edge < edges_.size();
  }
  return good;
}

bool PoseGraph::read_retired(NoteReader* in) {
  bool good = true;
  for (std::size_t n = in->count(2 * kNodeIdBytes + 72); n > 0 && good; --n) {
    const NodeId id = get_node(in);
    Retired retired;
    retired.utime_us = in->get<std::int64_t>();
    retired.carrier = get_node(in);
    retired.t_carrier_base_m = in->vector<double>();
    for (double& x : retired.q_carrier_base.coeffs()) x = in->finite();
    retired.translation_m2 = in->get<float>();
    retired.rotation_rad2 = in->get<float>();
    const auto carrier = nodes_.find(retired.carrier);
    good = carrier != nodes_.end() && nodes_.count(id) == 0 && retired_.emplace(id, retired).second;
    if (good)
      loads_.emplace(retired.carrier, Load{carrier->second.T_map_base, {}})
          .first->second.ids.push_back(id);
  }
  return good;
}

bool PoseGraph::restore(NoteReader* in) {
  PoseGraph restored(config_);
  const bool good = restored.read(in);
  if (!good) restored = PoseGraph(config_);
  restored.robot_ = robot_;
  restored.camera_ = camera_;
  // How long a solve takes it has forgotten; were the first one made at once, poses might wait for
  // seconds.
  if (restored.nodes_.size() >= kManyNodes) restored.quick_took_us_ = config_.longest_quick_us + 1;
  *this = std::move(restored);
  return good;
}

}  // namespace fusion_slam
