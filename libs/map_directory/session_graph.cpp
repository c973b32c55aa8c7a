#include "libs/map_directory/session_graph.hpp"

#include <algorithm>
#include <iterator>

#include "libs/messages/convert.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kNodesPerPart = 400;  // 81 bytes each

}  // namespace

void SessionGraph::add(const graph_t& message) {
  if (message.complete != 0 && message.nodes.empty()) nodes_.clear();  // the graph was reset
  if (message.revision >= revision_ && message.part == 0) {
    n_loops_ = message.n_loops;
    switched_off_ = message.switched_off;
    utime_us_ = std::max(utime_us_, message.utime);
  }
  revision_ = std::max(revision_, message.revision);
  for (const graph_node_t& node : message.nodes) {
    const bool a_kind = node.kind == graph_node_t::KEYFRAME || node.kind == graph_node_t::LIDAR;
    if (!a_kind || node.id <= 0 || !from_message(node.T_map_base)) continue;
    auto& held = nodes_[{static_cast<NodeKind>(node.kind), node.id}];
    if (message.revision >= held.first) held = {message.revision, node};
  }
}

std::map<NodeId, SE3> SessionGraph::T_map_nodes() const {
  std::map<NodeId, SE3> poses;
  for (const auto& [id, node] : nodes_) poses.emplace(id, *from_message(node.second.T_map_base));
  return poses;
}

std::vector<graph_t> SessionGraph::messages() const {
  const std::size_t n_parts =
      std::max<std::size_t>(1, (nodes_.size() + kNodesPerPart - 1) / kNodesPerPart);
  std::vector<graph_t> parts(n_parts);
  auto node = nodes_.begin();
  for (std::size_t i = 0; i < n_parts; ++i) {
    graph_t& part = parts[i];
    part = graph_t{};
    part.utime = utime_us_;
    part.seq = static_cast<std::int64_t>(i) + 1;
    part.revision = revision_;
    part.complete = 1;
    part.part = static_cast<std::int32_t>(i);
    part.n_parts = static_cast<std::int32_t>(n_parts);
    for (std::size_t n = 0; n < kNodesPerPart && node != nodes_.end(); ++n, ++node)
      part.nodes.push_back(node->second.second);
    part.n_nodes = static_cast<std::int32_t>(part.nodes.size());
    part.n_loops = n_loops_;
    if (i == 0) part.switched_off = switched_off_;
    part.n_switched_off = static_cast<std::int32_t>(part.switched_off.size());
  }
  return parts;
}

}  // namespace fusion_slam
