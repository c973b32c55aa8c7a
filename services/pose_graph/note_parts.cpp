#include "services/pose_graph/note_parts.hpp"

#include "services/pose_graph/pose_track.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kFeatureBytes = 29;

}  // namespace

void put_features(const std::vector<SeenFeature>& features, NoteWriter* out) {
  out->count(features.size());
  for (const SeenFeature& f : features) {
    out->put(f.landmark);
    out->put(static_cast<std::int32_t>(f.index));
    for (const float x : {f.u_px, f.v_px, f.depth_m, f.depth_sigma_m}) out->put(x);
    out->put(f.octave);
  }
}

std::vector<SeenFeature> get_features(NoteReader* in) {
  std::vector<SeenFeature> features(in->count(kFeatureBytes));
  for (SeenFeature& f : features) {
    f.landmark = in->get<std::int64_t>();
    f.index = in->get<std::int32_t>();
    for (float* x : {&f.u_px, &f.v_px, &f.depth_m, &f.depth_sigma_m}) *x = in->get<float>();
    f.octave = in->get<std::int8_t>();
  }
  return features;
}

void put_pairs(const std::vector<std::pair<int, int>>& pairs, NoteWriter* out) {
  out->count(pairs.size());
  for (const auto& [a, b] : pairs) {
    out->put(static_cast<std::int32_t>(a));
    out->put(static_cast<std::int32_t>(b));
  }
}

std::vector<std::pair<int, int>> get_pairs(NoteReader* in) {
  std::vector<std::pair<int, int>> pairs(in->count(8));
  for (auto& [a, b] : pairs) {
    a = in->get<std::int32_t>();
    b = in->get<std::int32_t>();
  }
  return pairs;
}

void put_edge(const GraphEdge& edge, NoteWriter* out) {
  out->put(static_cast<std::uint8_t>(edge.kind));
  for (const NodeId& id : {edge.from, edge.to, edge.said_from, edge.said_to}) put_node(id, out);
  out->pose(edge.T_from_to);
  out->symmetric(edge.covariance);
  out->put(edge.loop_weight);
  out->put(static_cast<std::uint8_t>(edge.adjusted.has_value()));
  if (edge.adjusted) out->pose(*edge.adjusted);
}

std::optional<GraphEdge> get_edge(NoteReader* in) {
  const auto kind = in->get<std::uint8_t>();
  if (kind > static_cast<std::uint8_t>(EdgeKind::kLoop)) return std::nullopt;
  GraphEdge edge;
  edge.kind = static_cast<EdgeKind>(kind);
  for (NodeId* id : {&edge.from, &edge.to, &edge.said_from, &edge.said_to}) *id = get_node(in);
  edge.T_from_to = in->pose();
  edge.covariance = in->symmetric();
  edge.loop_weight = in->finite();
  if (in->flag()) edge.adjusted = in->pose();
  return edge;
}

void put_node_input(const NodeInput& node, NoteWriter* out) {
  put_node(node.id, out);
  out->put(node.utime_us);
  out->pose(node.T_odom_base);
  out->put(node.previous_id);
  out->pose(node.T_previous_base);
  out->symmetric(node.covariance);
  out->count(node.refined.size());
  for (const NodeInput::Refined& refined : node.refined) {
    out->put(refined.id);
    out->pose(refined.T_previous_base);
  }
  put_features(node.seen, out);
}

NodeInput get_node_input(NoteReader* in) {
  NodeInput node;
  node.id = get_node(in);
  node.utime_us = in->get<std::int64_t>();
  node.T_odom_base = in->pose();
  node.previous_id = in->get<std::int64_t>();
  node.T_previous_base = in->pose();
  node.covariance = in->symmetric();
  node.refined.resize(in->count(8 + kPoseBytes));
  for (NodeInput::Refined& refined : node.refined) {
    refined.id = in->get<std::int64_t>();
    refined.T_previous_base = in->pose();
  }
  node.seen = get_features(in);
  return node;
}

void put_loop_input(const LoopInput& loop, NoteWriter* out) {
  put_node(loop.from, out);
  put_node(loop.to, out);
  out->pose(loop.T_from_to);
  out->symmetric(loop.covariance);
  put_pairs(loop.same_features, out);
}

LoopInput get_loop_input(NoteReader* in) {
  LoopInput loop;
  loop.from = get_node(in);
  loop.to = get_node(in);
  loop.T_from_to = in->pose();
  loop.covariance = in->symmetric();
  loop.same_features = get_pairs(in);
  return loop;
}

void put_loop_state(const LoopState& loop, NoteWriter* out) {
  put_node(loop.from, out);
  put_node(loop.to, out);
  out->put(loop.squared_error);
  out->some({loop.reason.begin(), loop.reason.end()});
}

LoopState get_loop_state(NoteReader* in) {
  LoopState loop;
  loop.from = get_node(in);
  loop.to = get_node(in);
  loop.squared_error = in->finite();
  const std::vector<std::uint8_t> reason = in->some();
  loop.reason.assign(reason.begin(), reason.end());
  return loop;
}

void PoseTrack::write(NoteWriter* out) const {
  out->put(static_cast<std::uint8_t>(broken_));
  out->count(poses_.size());
  for (const auto& [utime_us, pose] : poses_) {
    out->put(utime_us);
    out->pose(pose.T_odom_base);
    put_node(pose.reference, out);
    out->pose(pose.T_reference_base);
    out->symmetric(pose.covariance);
    out->put(pose.fix_utime_us);
    out->put(static_cast<std::uint8_t>(pose.after_break));
  }
}

void PoseTrack::read(NoteReader* in) {
  broken_ = in->flag();
  poses_.clear();
  for (std::size_t n = in->count(17 + kNodeIdBytes + 2 * kPoseBytes + kCovarianceBytes); n > 0;
       --n) {
    TrackPose pose;
    pose.utime_us = in->get<std::int64_t>();
    pose.T_odom_base = in->pose();
    pose.reference = get_node(in);
    pose.T_reference_base = in->pose();
    pose.covariance = in->symmetric();
    pose.fix_utime_us = in->get<std::int64_t>();
    pose.after_break = in->flag();
    poses_[pose.utime_us] = pose;
  }
}

void LandmarkStore::write(NoteWriter* out) const {
  out->count(keyframes_.size());
  for (const auto& [id, seen] : keyframes_) {
    out->put(id);
    put_features(*seen, out);
  }
}

void LandmarkStore::read(NoteReader* in) {
  keyframes_.clear();
  for (std::size_t n = in->count(12); n > 0; --n) {
    const auto id = in->get<std::int64_t>();
    add(id, get_features(in));
  }
}

}  // namespace fusion_slam
