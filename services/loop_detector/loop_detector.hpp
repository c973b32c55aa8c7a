// Says when the camera looks at a place it has seen before, in stages that each leave their
// verdict. Knows no bus.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/features/feature.hpp"
#include "libs/features/lsh_index.hpp"
#include "libs/geometry/pose.hpp"
#include "services/loop_detector/config.hpp"

namespace fusion_slam {

struct LoopKeyframe {
  std::int64_t id = 0;
  std::int64_t utime_us = 0;
  SE3 T_odom_base = SE3::Identity();
  FeatureSet features;  // ideal pixels
};

struct StageVerdict {
  std::string stage;  // appearance, geometry, lidar, consistency
  double score = 0.0;
  double threshold = 0.0;
  bool passed = false;
  std::string reason;
};

struct LoopCandidate {
  std::int64_t from_id = 0;  // the older keyframe
  std::int64_t to_id = 0;    // the newer
  std::int64_t utime_us = 0;
  bool accepted = false;
  std::vector<StageVerdict> stages;            // all four, in order
  SE3 T_from_to = SE3::Identity();             // base to base; only when geometry passed
  Matrix6d covariance = Matrix6d::Identity();  // of it, base axes
};

class LoopDetector {
 public:
  LoopDetector(const CameraModel& camera, const SE3& T_base_camera,
               const LoopDetectorConfig& config = {});

  // Looks for the places that this keyframe shows, then remembers it. Every place that passes the
  // appearance stage is returned with its fate. A keyframe whose id is not above the last one's is
  // ignored.
  std::vector<LoopCandidate> add(LoopKeyframe keyframe);

  // Where the graph has moved a keyframe to; for reasons in verdicts only, in this version.
  void moved(std::int64_t keyframe_id, const SE3& T_map_base);

  std::size_t n_keyframes() const { return keyframes_.size(); }

 private:
  struct Place {
    std::int64_t id = 0;
    int votes = 0;
  };

  void admit(const LoopKeyframe& newest);
  std::vector<Place> similar_places(const FeatureSet& set) const;
  LoopCandidate examine(const Place& place, const LoopKeyframe& keyframe) const;
  SE3 T_map_base(const LoopKeyframe& keyframe) const;

  LoopDetectorConfig config_;
  CameraModel camera_;
  SE3 T_base_camera_;
  LshIndex index_;
  std::map<std::int64_t, LoopKeyframe> keyframes_;
  std::map<std::int64_t, SE3> T_map_base_;
  std::deque<std::int64_t> waiting_;  // too young to be a place
};

}  // namespace fusion_slam
