// The part of the report that comes from trajectories and maps.
#pragma once

#include <filesystem>
#include <optional>

#include "libs/evaluation/trajectory_error.hpp"
#include "libs/report/page.hpp"

namespace fusion_slam {

struct Accuracy {
  Trajectory estimate;                 // trajectory.tum; empty when there is none
  Trajectory reference;                // groundtruth.tum; empty when there is none
  std::optional<TrajectoryError> ape;  // aligned by SE(3), metres
  std::optional<TrajectoryError> rpe;  // frame to frame, metres
};

Accuracy read_accuracy(const std::filesystem::path& run);

// Fused map with the way; beside it the true map, when there is one.
Section map_section(const std::filesystem::path& run, const std::filesystem::path& truth_map,
                    const Accuracy& accuracy);
Section error_section(const Accuracy& accuracy);

}  // namespace fusion_slam
