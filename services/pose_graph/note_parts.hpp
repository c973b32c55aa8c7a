// Inputs and edges of the pose graph in journal notes (docs/formats.md). Pure.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libs/graph/edge.hpp"
#include "libs/graph/node_bytes.hpp"
#include "services/pose_graph/graph_inputs.hpp"

namespace fusion_slam {

// The fewest bytes that one of them takes.
constexpr std::size_t kNodeIdBytes = 9;
constexpr std::size_t kPoseBytes = 96;
constexpr std::size_t kCovarianceBytes = 168;
constexpr std::size_t kEdgeBytes = 10 + 4 * kNodeIdBytes + kPoseBytes + kCovarianceBytes;
constexpr std::size_t kNodeInputBytes = 24 + kNodeIdBytes + 2 * kPoseBytes + kCovarianceBytes;
constexpr std::size_t kLoopInputBytes = 4 + 2 * kNodeIdBytes + kPoseBytes + kCovarianceBytes;

void put_features(const std::vector<SeenFeature>& features, NoteWriter* out);
std::vector<SeenFeature> get_features(NoteReader* in);
void put_pairs(const std::vector<std::pair<int, int>>& pairs, NoteWriter* out);
std::vector<std::pair<int, int>> get_pairs(NoteReader* in);
void put_edge(const GraphEdge& edge, NoteWriter* out);
std::optional<GraphEdge> get_edge(NoteReader* in);  // nothing: there is no such kind
void put_node_input(const NodeInput& node, NoteWriter* out);
NodeInput get_node_input(NoteReader* in);
void put_loop_input(const LoopInput& loop, NoteWriter* out);
LoopInput get_loop_input(NoteReader* in);
void put_loop_state(const LoopState& loop, NoteWriter* out);
LoopState get_loop_state(NoteReader* in);

}  // namespace fusion_slam
