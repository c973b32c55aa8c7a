// Where an RGB-D camera has moved, frame by frame, with keyframes for the pose graph. Knows no bus.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "libs/camera/camera_model.hpp"
#include "libs/camera/rgbd_frame.hpp"
#include "libs/features/orb_extractor.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/keyframe_decision.hpp"
#include "services/visual_odometry/local_map.hpp"
#include "services/visual_odometry/motion_model.hpp"
#include "services/visual_odometry/projection_matcher.hpp"

namespace fusion_slam {

enum class TrackingState { kUnknown, kOk, kWeak, kLost };

struct Keyframe {
  std::int64_t id = 0;  // 1, 2, 3 ...
  std::int64_t utime_us = 0;
  SE3 T_odom_base = SE3::Identity();
  std::int64_t previous_id = 0;  // 0: none, a new segment
  SE3 T_previous_base = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();     // of T_previous_base, base axes
  FeatureSet features;                            // ideal pixels
  std::vector<std::int64_t> landmark_of_feature;  // one a feature; 0: none
};

struct TrackingResult {
  std::int64_t utime_us = 0;
  TrackingState state = TrackingState::kUnknown;
  std::string reason;  // why the state is not OK
  SE3 T_odom_base = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // of T_odom_base given the local map, base axes
  std::int64_t reference_id = 0;               // keyframe; 0: none yet
  SE3 T_reference_base = SE3::Identity();
  std::int64_t fix_utime_us = 0;  // when the pose was last measured
  int n_matched = 0;
  std::optional<Keyframe> keyframe;  // when this frame became one
};

class VisualOdometry {
 public:
  VisualOdometry(const CameraModel& camera, const SE3& T_base_camera,
                 const VisualOdometryConfig& config = {});

  // Tracks one frame. Frames must come in order of utime; a frame that is older than the last,
  // empty or not of the camera's size gives state kUnknown with the reason and changes nothing.
  TrackingResult track(const RgbdFrame& frame);

  // Forgets the map; the next frame starts a new segment at the last pose.
  void reset();

 private:
  struct Estimate {
    SE3 T_odom_camera = SE3::Identity();
    Matrix6d covariance = Matrix6d::Identity();  // camera axes
    ProjectionMatches matched;                   // inliers only
  };

  std::string refuse(const RgbdFrame& frame) const;  // why not; empty: good
  FeatureSet see(const RgbdFrame& frame) const;
  std::optional<Estimate> track_map(const SE3& guess, const FeatureSet& set,
                                    double radius_px) const;
  Estimate estimate_pose(const SE3& guess, const FeatureSet& set, const FeatureGrid& grid,
                         double radius_px) const;
  TrackingResult tracked(std::int64_t utime_us, const Estimate& estimate, FeatureSet set);
  TrackingResult lost(std::int64_t utime_us, FeatureSet set);
  void add_keyframe(const Estimate& estimate, bool connected, FeatureSet set,
                    TrackingResult* result);
  void fill_pose(const SE3& T_odom_camera, TrackingResult* result) const;

  VisualOdometryConfig config_;
  CameraModel camera_;
  SE3 T_base_camera_;
  OrbExtractor extractor_;
  std::vector<double> scales_;
  MotionModel motion_;
  LocalMap map_;
  SE3 T_odom_camera_ = SE3::Identity();    // last pose
  SE3 T_odom_keyframe_ = SE3::Identity();  // camera pose of the last keyframe
  std::int64_t keyframe_id_ = 0;
  int inliers_at_keyframe_ = 0;
  bool fresh_keyframe_ = false;
  bool segment_started_ = false;
  std::int64_t last_utime_us_ = 0;
  std::int64_t fix_utime_us_ = 0;
};

}  // namespace fusion_slam
