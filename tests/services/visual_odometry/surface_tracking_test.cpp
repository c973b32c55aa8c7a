#include "services/visual_odometry/surface_tracking.hpp"

#include <random>

#include <gtest/gtest.h>

#include "libs/camera/camera_model.hpp"

namespace fusion_slam {
namespace {

// Planes in odom, n . p = d; a ray takes the nearest one in front of it.
struct Plane {
  Eigen::Vector3d n;
  double d;
};

// A camera in the corner of a room: two walls and the floor (optical axes at the origin).
const std::vector<Plane> kCorner{
    {{0.0, 0.0, 1.0}, 2.5}, {{1.0, 0.0, 0.0}, 0.9}, {{0.0, 1.0, 0.0}, 0.6}};
const std::vector<Plane> kWall{{{0.0, 0.0, 1.0}, 2.0}};

cv::Mat depth_of(const std::vector<Plane>& planes, const CameraModel& camera, const SE3& T,
                 std::mt19937* random) {
  cv::Mat depth(camera.height_px, camera.width_px, CV_16UC1, cv::Scalar(0));
  std::normal_distribution<double> noise;
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const Eigen::Vector3d ray = T.linear() * camera.unproject(u, v, 1.0);
      double z = 1e9;
      for (const Plane& plane : planes) {
        const double at = (plane.d - plane.n.dot(T.translation())) / plane.n.dot(ray);
        if (at > 0.0) z = std::min(z, at);
      }
      if (z > 6.0) continue;
      depth.at<std::uint16_t>(v, u) =
          cv::saturate_cast<std::uint16_t>(1000.0 * (z + camera.depth_sigma(z) * noise(*random)));
    }
  return depth;
}

class SurfaceTracking : public ::testing::Test {
 protected:
  SurfaceView view(const std::vector<Plane>& planes, const SE3& T) {
    return see_surfaces(depth_of(planes, camera_, T, &random_), camera_, config_);
  }

  CameraModel camera_;
  SurfaceConfig config_;
  std::mt19937 random_{7};
  const SE3 before_ = from_xyz_rpy(0.05, -0.03, 0.1, 0.02, -0.05, 0.03);
  const SE3 moved_ = from_xyz_rpy(0.012, -0.006, 0.015, 0.01, 0.02, -0.008);
};

TEST_F(SurfaceTracking, NormalsArePlanes) {
  const SurfaceView seen = view(kWall, SE3::Identity());
  int n = 0;
  for (const SurfaceSample& s : seen.samples) {
    if (s.point.z() <= 0.0) continue;
    ++n;
    EXPECT_LT(s.normal.z(), -0.99);
    EXPECT_NEAR(s.point.z(), 2.0, 0.02);
  }
  EXPECT_GT(n, 0.9 * seen.columns * seen.rows);
}

TEST_F(SurfaceTracking, ACornerTellsTheWholeMotion) {
  const SE3 truth = before_ * moved_;
  const auto motion = track_surfaces(view(kCorner, before_), before_, view(kCorner, truth), before_,
                                     camera_, nullptr, config_);
  ASSERT_TRUE(motion);
  const Vector6d error = local(truth, motion->T_odom_camera);
  EXPECT_LT(error.head<3>().norm(), 0.003);
  EXPECT_LT(error.tail<3>().norm(), 0.002);
}

TEST_F(SurfaceTracking, AlongAWallThePredictionIsKeptAndItsDoubtSaid) {
  const SE3 truth = before_ * moved_;
  SE3 guess = truth;
  guess.translation().x() += 0.008;  // along the wall
  guess.translation().z() += 0.010;  // towards it
  const auto motion = track_surfaces(view(kWall, before_), before_, view(kWall, truth), guess,
                                     camera_, nullptr, config_);
  ASSERT_TRUE(motion);
  EXPECT_NEAR(motion->T_odom_camera.translation().z(), truth.translation().z(), 0.002);
  EXPECT_NEAR(motion->T_odom_camera.translation().x(), guess.translation().x(), 0.002);
  EXPECT_GT(motion->covariance(0, 0), 0.25 * config_.prior_sigma_m * config_.prior_sigma_m);
  EXPECT_LT(motion->covariance(2, 2), 1e-5);
}

TEST_F(SurfaceTracking, TheSurfacesAloneSayNothingOfSlidingAlongAWall) {
  const SE3 truth = before_ * moved_;
  const auto motion = track_surfaces(view(kWall, before_), before_, view(kWall, truth), truth,
                                     camera_, nullptr, config_);
  ASSERT_TRUE(motion);
  const Matrix6d& H = motion->information;
  EXPECT_LT(H(0, 0), 0.02 * H(2, 2));
  EXPECT_LT(H(1, 1), 0.02 * H(2, 2));
  EXPECT_GT(H(4, 4), 0.0);
}

TEST_F(SurfaceTracking, OtherSurfacesAndNoneGiveNothing) {
  const SurfaceView corner = view(kCorner, before_);
  const SurfaceView elsewhere = view({{{0.3, 0.0, 0.95}, 1.4}}, before_);
  const SurfaceView none =
      see_surfaces(cv::Mat(480, 640, CV_16UC1, cv::Scalar(0)), camera_, config_);
  for (const SurfaceView& other : {elsewhere, none, SurfaceView{}}) {
    EXPECT_FALSE(track_surfaces(corner, before_, other, before_, camera_, nullptr, config_));
    EXPECT_FALSE(track_surfaces(other, before_, corner, before_, camera_, nullptr, config_));
  }
}

}  // namespace
}  // namespace fusion_slam
