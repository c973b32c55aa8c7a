// The relations metric of Kuemmerle et al. 2009, "On measuring the accuracy of SLAM algorithms": a
// person has verified, for many pairs of times, how the robot stood at the second time seen from
// where it stood at the first. A trajectory is judged by how well it reproduces these relative
// poses, which needs no common frame and no alignment.
#pragma once

#include <cstddef>
#include <filesystem>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "libs/evaluation/number_rows.hpp"
#include "libs/evaluation/outcome.hpp"
#include "libs/evaluation/statistics.hpp"
#include "libs/evaluation/trajectory.hpp"

namespace fusion_slam {

struct PoseRelation {
  double time_1_s = 0.0;
  double time_2_s = 0.0;
  SE3 T_1_2 = SE3::Identity();  // the pose at time 2 in the frame of the pose at time 1
};

// Lines "t1 t2 x y z roll pitch yaw" (s, m, rad). Throws FileError as read_tum() does.
std::vector<PoseRelation> read_relations(const std::filesystem::path& file);
std::vector<PoseRelation> read_relations(std::istream& in, const std::string& name);

struct RelationsOptions {
  double time_offset_s = 0.0;  // added to the trajectory's times
  // The pose at a time is interpolated between the two poses around it, as Cartographer's
  // evaluation does it, or is the nearest one: better where the relation's times and the log's are
  // stamps of the same scans by two clocks that jitter against each other, as they are for fr079
  // (docs/evaluation.md has the numbers).
  bool nearest = false;
  // Poses further apart than this leave the time between them unknown, and its relations unusable.
  // The sparsest scans of fr079, the benchmark's own log, are 2.3 s apart.
  double max_gap_s = 2.5;
};

struct RelationsError {
  Statistics translation_m;  // length of the error's translation
  Statistics rotation_deg;   // its absolute rotation angle
  std::size_t usable = 0;
  std::size_t total = 0;

  double usable_percent() const;
};

// The pose at a time of the trajectory's own clock, or nothing: before the first pose, after the
// last, in a gap.
std::optional<SE3> pose_at(const Trajectory& trajectory, double time_s,
                           const RelationsOptions& options);

// Error of a relation: expected^-1 * (T1^-1 * T2). Fails when no relation is usable and says which
// times don't meet.
Outcome<RelationsError> evaluate_relations(const std::vector<PoseRelation>& relations,
                                           const Trajectory& estimate,
                                           const RelationsOptions& options);

}  // namespace fusion_slam
