// Between the messages of the bus and the pose graph's own types. Pure; nothing where a motion is
// not rigid or a node's kind does not exist.
#pragma once

#include <optional>
#include <string>

#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/graph_node_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "fusion_slam/loop_state_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {

std::optional<NodeInput> node_from(const keyframe_t& message);
std::optional<NodeInput> node_from(const lidar_node_t& message);
PoseInput pose_from(NodeKind sensor, const pose_estimate_t& message);
std::optional<LoopInput> loop_from(const constraint_t& message);

graph_node_t to_message(const NodeId& id, const GraphNode& node);
pose_estimate_t to_message(const PoseOutput& pose);
loop_state_t to_message(const LoopState& loop);
LoopState state_from(const loop_state_t& message);
// RETIRED, a record of the journal: from the carrier to the retired node; seq: the number of nodes
// that had come.
constraint_t to_message(const Retirement& retirement, std::int64_t utime_us, std::int64_t n_placed);
std::optional<Retirement> retirement_from(const constraint_t& message);

bool is_node_kind(std::int8_t kind);

}  // namespace fusion_slam
