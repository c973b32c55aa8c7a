// The 3D points that the last few keyframes saw, in odom. What the current frame is tracked
// against.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/features/feature.hpp"
#include "libs/geometry/pose.hpp"

namespace fusion_slam {

struct MapPoint {
  Eigen::Vector3d p_odom = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information =
      Eigen::Matrix3d::Zero();  // of p_odom, sum over its observations, 1/m^2
  Eigen::Vector3d viewed_from =
      Eigen::Vector3d::Zero();  // unit, from the point to the camera that saw it last
  Descriptor descriptor{};
  float angle_rad = 0.0F;
  double reach_m = 0.0;  // distance * scale: what would be seen at octave 0 at this distance
  std::int64_t last_keyframe = 0;  // the newest that saw it
  int visible = 0;                 // frames in which it should have been seen
  int found = 0;                   // and was
};

class LocalMap {
 public:
  using Points = std::map<std::int64_t, MapPoint>;

  const Points& points() const { return points_; }
  bool empty() const { return points_.empty(); }
  void clear();

  // Counts for culling: frames in which a point was in view, and in which it was matched.
  void count_visible(std::int64_t point) { ++points_.at(point).visible; }
  void count_found(std::int64_t point) { ++points_.at(point).found; }

  // Merges what a new keyframe saw: point_of_feature[i] is the point that feature i was matched to
  // (then its position is averaged by information and its look is renewed) or 0 (then a point is
  // made, when it has depth, and its id filled in). Forgets points that the last `keep` keyframes
  // did not see and those that are hardly ever found where they should be.
  void add_keyframe(std::int64_t id, const CameraModel& camera, const SE3& T_odom_camera,
                    const FeatureSet& set, const std::vector<double>& scale_of_octave,
                    double pixel_sigma, int keep, std::vector<std::int64_t>* point_of_feature);

 private:
  Points points_;
  std::deque<std::int64_t> keyframes_;
  std::int64_t next_point_ = 1;
};

// Information (inverse covariance) in odom of a point measured by one RGB-D observation.
Eigen::Matrix3d observation_information(const CameraModel& camera, const SE3& T_odom_camera,
                                        const Eigen::Vector3d& p_camera, double pixel_sigma_px);

}  // namespace fusion_slam
