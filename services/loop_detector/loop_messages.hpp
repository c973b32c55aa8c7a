// Between the messages of the bus and the loop detector's own types. Pure.
#pragma once

#include <optional>
#include <string>

#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "fusion_slam/loop_candidate_t.hpp"
#include "services/loop_detector/loop_types.hpp"

namespace fusion_slam {

// Nothing, with a reason in `why`, when numbers are not finite or contradict each other.
std::optional<LoopKeyframe> from_message(const keyframe_t& message, std::string* why);
std::optional<LoopScan> from_message(const lidar_node_t& message, std::string* why);

loop_candidate_t to_message(const LoopCandidate& candidate);
constraint_t to_message(const LoopMeasurement& loop, std::int64_t utime_us);

}  // namespace fusion_slam
