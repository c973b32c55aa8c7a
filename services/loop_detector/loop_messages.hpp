// Between the messages of the bus and the loop detector's own types. Pure.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "fusion_slam/loop_candidate_t.hpp"
#include "services/loop_detector/loop_types.hpp"

namespace fusion_slam {

// Nothing, with a reason in `why`, when numbers are not finite or contradict each other.
std::optional<LoopKeyframe> from_message(const keyframe_t& message, std::string* why);
std::optional<LoopScan> from_message(const lidar_node_t& message, std::string* why);

// An edge that was found earlier, without its features. Nothing: T_from_to is no rigid motion.
std::optional<LoopMeasurement> from_message(const constraint_t& message);
NodeKind kind_of(std::int8_t kind);  // graph_node_t's

loop_candidate_t to_message(const LoopCandidate& candidate);
constraint_t to_message(const LoopMeasurement& loop, std::int64_t utime_us);

// Notes in the detector's journal: keyframes, by their ids, that are no places any more, and places
// that are known well (KnownPlacesNews).
constexpr const char* kRetiredNote = "RETIRED";
constexpr const char* kKnownPlacesNote = "KNOWN_PLACES";
graph_t note_of(const std::vector<NodeId>& keyframes);
void take_note(const graph_t& note, std::vector<NodeId>* keyframes);

}  // namespace fusion_slam
