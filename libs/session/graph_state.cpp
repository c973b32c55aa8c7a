#include "libs/session/graph_state.hpp"

#include <algorithm>

#include "libs/messages/convert.hpp"

namespace fusion_slam {

// A node of an older revision than the one held is old news; one message of a large revision may
// come late.
void GraphState::add(const graph_t& message) {
  if (message.complete != 0 && message.nodes.empty()) {  // the graph was reset
    nodes_.clear();
    revision_ = message.revision;
  }
  revision_ = std::max(revision_, message.revision);
  for (const graph_node_t& node : message.nodes) {
    const auto T_map_base = from_message(node.T_map_base);
    if (!T_map_base || node.id <= 0) continue;
    const Node newer{message.revision, *T_map_base};
    const auto [held, made] =
        nodes_.try_emplace({static_cast<NodeKind>(node.kind), node.id}, newer);
    if (!made && message.revision >= held->second.revision) held->second = newer;
  }
}

std::map<NodeId, SE3> GraphState::T_map_nodes() const {
  std::map<NodeId, SE3> result;
  for (const auto& [id, node] : nodes_) result.emplace(id, node.T_map_base);
  return result;
}

}  // namespace fusion_slam
