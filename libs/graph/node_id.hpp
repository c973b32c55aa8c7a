// Name of a pose-graph node. Ids of different kinds can't be mixed up.
#pragma once

#include <cstdint>
#include <tuple>

namespace fusion_slam {

enum class NodeKind : std::int8_t { kKeyframe = 0, kLidar = 1 };  // graph_node_t's constants

struct NodeId {
  NodeKind kind = NodeKind::kKeyframe;
  std::int64_t id = 0;  // 1, 2, 3 ... of its kind; 0: no node

  bool operator<(const NodeId& other) const {
    return std::tie(kind, id) < std::tie(other.kind, other.id);
  }
  bool operator==(const NodeId& other) const { return kind == other.kind && id == other.id; }
  bool operator!=(const NodeId& other) const { return !(*this == other); }
};

}  // namespace fusion_slam
