// What the pose graph says about keyframes, and how a loop closure reaches the map of visual
// odometry without a jump in odom.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {

// What a revision of the graph changed in the map.
struct Revised {
  std::vector<std::int64_t> keyframes;  // that were moved, ascending
  std::vector<std::int64_t> landmarks;  // new ones: copies that moved keyframes keep for themselves
};

class GraphRevision {
 public:
  // A node of GRAPH.
  void update(std::int64_t keyframe, const SE3& T_map_base);

  // When the graph has bent since the last call (some keyframe has moved against `reference` by
  // more than config.revision_m or revision_rad), lays those keyframes where the graph says they
  // are as seen from `reference`. The reference and the newest config.settle_keyframes stay where
  // they are, and every landmark stays with the newest keyframe that sees it
  // (VisualMap::carry_landmarks): nothing that the camera can be tracked by has moved, so its pose
  // in odom does not change. Observations and surface ties do not reach across the tear.
  Revised take_up(std::int64_t reference, const SE3& T_base_camera,
                  const VisualOdometryConfig& config, VisualMap* map);

  // Of this keyframe, nothing is known any more (it was forgotten).
  void forget(std::int64_t keyframe);

 private:
  void forget_gone(const VisualMap& map);

  std::map<std::int64_t, SE3> said_;   // newest
  std::map<std::int64_t, SE3> taken_;  // as of the last take_up()
  bool news_ = false;
};

}  // namespace fusion_slam
