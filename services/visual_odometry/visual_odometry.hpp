// Where an RGB-D camera has moved, frame by frame, with keyframes for the pose graph. Knows no bus.
// Not thread-safe; has one thread of its own (local_mapping.hpp), on which results don't depend
// when config.wait_for_mapping.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/camera/rgbd_frame.hpp"
#include "libs/features/orb_extractor.hpp"
#include "libs/robot/robot_model.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/graph_revision.hpp"
#include "services/visual_odometry/keyframe_decision.hpp"
#include "services/visual_odometry/landmark_creation.hpp"
#include "services/visual_odometry/lidar_motion.hpp"
#include "services/visual_odometry/local_mapping.hpp"
#include "services/visual_odometry/motion_model.hpp"
#include "services/visual_odometry/place_index.hpp"
#include "services/visual_odometry/pose_tracking.hpp"
#include "services/visual_odometry/thinning.hpp"
#include "services/visual_odometry/tracking_result.hpp"

namespace fusion_slam {

class VisualOdometry {
 public:
  // Takes T_base_camera and, for its LiDAR, the mounting and the noise from `robot`.
  VisualOdometry(const CameraModel& camera, const RobotModel& robot,
                 const VisualOdometryConfig& config = {});

  // Tracks one frame. Frames must come in order of utime (a second or more back: the robot's clock
  // was set back, and this is the next frame); a frame that is older than the last,
  // empty or not of the camera's size gives state kUnknown with the reason and changes nothing.
  // The images must not be changed afterwards. `features`: null, or what find_features() gives.
  TrackingResult track(const RgbdFrame& frame, const FeatureSet* features = nullptr);

  // What the other sensor and the pose graph say; each may be left out altogether.
  void add_scan(LaserScan scan);
  void add_lidar_pose(std::int64_t utime_us, const SE3& T_odom_base);  // LIDAR_POSE, OK or WEAK
  void add_graph_node(std::int64_t keyframe_id, const SE3& T_map_base);

  // Goes on where an earlier process ended, before the first frame: its last keyframes of one
  // segment, oldest first. The odometry frame goes on, and ids do, from first_id on if that is
  // larger (after a power cut, when nobody knows which ids were given last).
  void resume(const std::vector<Keyframe>& keyframes, std::int64_t first_id = 1);

  // Forgets the map; the next frame starts a new segment at the last pose.
  void reset();

  const VisualMap& map() const { return map_; }
  const PlaceIndex& places() const { return places_; }
  const VisualOdometryCounts& counts() const { return counts_; }

 private:
  std::string refuse(const RgbdFrame& frame) const;  // why not; empty: good
  bool was_set_back(std::int64_t utime_us) const;    // the robot's clock
  void look_at_clock(std::int64_t utime_us);
  FeatureSet see(const RgbdFrame& frame, const FeatureSet* features);
  void take_up_news();
  bool follow_graph();
  void start_mapping();
  std::map<std::int64_t, std::int64_t> finish_mapping();  // landmarks that became others
  void renew_local_map();
  struct Guess {
    SE3 T_odom_camera = SE3::Identity();
    bool by_lidar = false;
  };
  std::vector<Guess> guesses(std::int64_t utime_us) const;
  std::optional<SE3> lidar_prediction(std::int64_t utime_us) const;  // T_odom_camera
  std::optional<PoseEstimate> track_from(const std::vector<Guess>& guesses, const FeatureSet& set);
  std::optional<PoseEstimate> carry_on(std::int64_t utime_us, const FeatureSet& set);
  SurfaceTie tie_to_reference() const;
  std::optional<PoseEstimate> find_again(std::int64_t utime_us, const FeatureSet& set,
                                         bool refuted);
  bool contradicts_lidar(std::int64_t utime_us, const PoseEstimate& estimate,
                         std::size_t n_features) const;
  TrackingResult place(const RgbdFrame& frame, const FeatureSet* features);
  TrackingResult tracked(std::int64_t utime_us, const PoseEstimate& estimate, FeatureSet set);
  TrackingResult lost(std::int64_t utime_us, const std::string& why, FeatureSet set);
  TrackingResult start_segment(std::int64_t utime_us, FeatureSet set);
  std::vector<SeenLandmark> landmarks_in(const PoseEstimate& estimate) const;
  void count_looks(const PoseEstimate& estimate);
  bool wants_keyframe(const PoseEstimate& estimate, const FeatureSet& set);
  void add_keyframe(std::vector<SeenLandmark> seen, bool connected, FeatureSet set,
                    TrackingResult* result);
  void join_segments();
  std::vector<RefinedEdge> settled_edges();
  void fill_pose(const SE3& T_odom_camera, TrackingResult* result) const;
  SE3 T_odom_reference() const;

  VisualOdometryConfig config_;
  CameraModel camera_;
  RobotModel robot_;
  OrbExtractor extractor_;
  std::vector<double> scales_;
  MotionModel motion_;
  LidarMotion lidar_motion_;
  SeenSurfaces surfaces_;              // of the last frame, when it has a pose; empty otherwise
  SeenSurfaces now_;                   // of this frame
  SeenSurfaces surfaces_of_keyframe_;  // of keyframe surfaces_keyframe_
  std::int64_t surfaces_keyframe_ = 0;
  Matrix6d carried_ = Matrix6d::Zero();  // covariance since features were last measured
  std::optional<LaserScan> scan_;
  GraphRevision revision_;
  VisualMap map_;
  LocalMap local_;
  PlaceIndex places_;
  LocalMapping mapping_;
  KeyframeThinning thinning_;

  SE3 T_odom_camera_ = SE3::Identity();  // last pose
  std::int64_t reference_ = 0;           // keyframe that poses hang on; 0: none
  std::int64_t newest_ = 0;              // last keyframe's id
  std::int64_t first_id_ = 1;            // none is smaller from now on
  std::int64_t mapped_ = 0;              // the last that local mapping was started for
  int segment_ = 0;
  int n_segments_ = 0;                         // that are not joined
  std::map<std::int64_t, std::int64_t> open_;  // keyframes whose edge may still change: previous
  int frames_since_keyframe_ = 0;
  int inliers_at_keyframe_ = 0;
  bool segment_started_ = false;
  bool resumed_ = false;                 // and nothing tracked since
  bool found_again_ = false;             // this frame: a keyframe ties the place to what follows
  bool weak_ = false;                    // the last frame was not OK
  std::int64_t last_utime_us_ = 0;       // of a frame
  std::int64_t pose_utime_us_ = 0;       // of T_odom_camera_
  std::int64_t fix_utime_us_ = 0;        // of the last measured pose
  std::int64_t searching_since_us_ = 0;  // first of the lost frames that show something; 0: none
  VisualOdometryCounts counts_;
};

}  // namespace fusion_slam
