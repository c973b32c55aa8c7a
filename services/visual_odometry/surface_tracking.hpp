// The camera's motion between two frames from the surfaces that its depth image shows: what is left
// in front of a bare wall, where colour has nothing to say.
// Sources: Chen & Medioni 1991 (point to plane); Newcombe et al. 2011, section 3.5 (projective
// association, gates on distance and normal). What surfaces leave open (sliding along a wall) is
// held by the speed: a prior on the motion with the predicted one as its mean.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "libs/camera/camera_model.hpp"
#include "libs/features/planar_prior.hpp"
#include "libs/geometry/pose.hpp"

namespace fusion_slam {

struct SurfaceConfig {
  int step_px = 8;                // between two samples
  int smooth_samples = 2;         // a normal is the mean over so many samples to each side
  double gate_m = 0.06;           // between a point and the plane it should lie on
  double gate_cosine = 0.87;      // 30 degrees between normals
  int min_pairs = 400;            // samples of both frames on one surface
  double min_share = 0.6;         // of the samples that fall into the other image
  double noise_factor = 4.0;      // neighbours err alike: each counts for less than one
  double prior_sigma_m = 0.006;   // how much a frame may differ from the predicted motion where
  double prior_sigma_rad = 0.01;  // surfaces don't tell
  int iterations = 8;
};

// A small plane in the camera's frame; z 0: none there.
struct SurfaceSample {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit, towards the camera
};

// Samples every step_px, row by row.
struct SurfaceView {
  int columns = 0;
  int rows = 0;
  std::vector<SurfaceSample> samples;
};

// From a CV_16UC1 depth image in mm (0: none). Lens distortion is not taken out: both views of a
// pair have the same. Pure.
SurfaceView see_surfaces(const cv::Mat& depth_mm, const CameraModel& camera,
                         const SurfaceConfig& config);

// The surfaces of a depth image, worked out when they are first asked for: most frames have
// features enough and never ask. Shares the image, which must not be changed. Not thread-safe.
class SeenSurfaces {
 public:
  SeenSurfaces() = default;  // an empty view
  explicit SeenSurfaces(cv::Mat depth_mm) : depth_mm_(std::move(depth_mm)) {}

  const SurfaceView& view(const CameraModel& camera, const SurfaceConfig& config) const {
    if (!view_) view_ = depth_mm_.empty() ? SurfaceView{} : see_surfaces(depth_mm_, camera, config);
    return *view_;
  }

 private:
  cv::Mat depth_mm_;
  mutable std::optional<SurfaceView> view_;
};

struct SurfaceMotion {
  SE3 T_odom_camera = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // given the earlier pose, camera axes
  // What the surfaces alone say of xi in retract(): nothing of what the speed does. Singular where
  // they leave a motion open.
  Matrix6d information = Matrix6d::Zero();
  int n_pairs = 0;
};

// Pose of `now` given that of `before`; nothing when the two show too little of the same surfaces,
// or don't fit. `planar`: null, or the floor. Pure.
std::optional<SurfaceMotion> track_surfaces(const SurfaceView& before, const SE3& T_odom_before,
                                            const SurfaceView& now, const SE3& guess_T_odom_camera,
                                            const CameraModel& camera, const PlanarPrior* planar,
                                            const SurfaceConfig& config);

}  // namespace fusion_slam
