#include "drivers/simulator/image_motion.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "drivers/simulator/auto_exposure.hpp"
#include "drivers/simulator/hand_held.hpp"

namespace fusion_slam {
namespace {

const CameraTwist kTwist{{0.3, -0.1, 0.5}, {0.2, -0.6, 0.3}};

// Camera moved by the twist for dt.
SE3 moved(const CameraTwist& twist, double dt_s) {
  SE3 T = SE3::Identity();
  T.translation() = dt_s * twist.linear_m_s;
  T.linear() = exp_so3(dt_s * twist.angular_rad_s);
  return T;
}

TEST(ImageMotion, VelocityIsThatOfProjectedPoints) {
  const CameraModel camera;
  constexpr double kDt = 1e-6;
  for (const double z : {0.7, 2.0, 6.0})
    for (const double u : {10.0, 320.0, 600.0})
      for (const double v : {20.0, 239.5, 450.0}) {
        const Eigen::Vector3d p = camera.unproject(u, v, z);
        const Eigen::Vector2d later = camera.project(moved(kTwist, kDt).inverse() * p);
        const Eigen::Vector2d numeric = (later - Eigen::Vector2d(u, v)) / kDt;
        EXPECT_LT((image_velocity(camera, kTwist, u, v, z) - numeric).norm(), 1e-2);
      }
}

TEST(ImageMotion, TwistBetweenPosesIsTheirRate) {
  const CameraTwist twist = twist_between(SE3::Identity(), moved(kTwist, 1e-3), 1e-3);
  EXPECT_LT((twist.linear_m_s - kTwist.linear_m_s).norm(), 1e-9);
  EXPECT_LT((twist.angular_rad_s - kTwist.angular_rad_s).norm(), 1e-9);
}

// A wall with a smooth pattern on it, seen by a camera.
double pattern(double x, double y) { return 120.0 + 60.0 * std::sin(9.0 * x) * std::cos(7.0 * y); }
void look(const CameraModel& camera, const SE3& T_world_camera, cv::Mat_<cv::Vec3f>* colour,
          cv::Mat_<float>* depth) {
  colour->create(camera.height_px, camera.width_px);
  depth->create(camera.height_px, camera.width_px);
  for (int v = 0; v < camera.height_px; ++v)
    for (int u = 0; u < camera.width_px; ++u) {
      const Eigen::Vector3d ray = T_world_camera.linear() * camera.unproject(u, v, 1.0);
      const double z = (2.0 - T_world_camera.translation().z()) / ray.z();  // wall at world z = 2
      const Eigen::Vector3d p = T_world_camera.translation() + z * ray;
      const auto grey = static_cast<float>(pattern(p.x(), p.y()));
      (*colour)(v, u) = cv::Vec3f(grey, grey, grey);
      (*depth)(v, u) = static_cast<float>(z);
    }
}

CameraModel small_camera() {
  CameraModel camera;
  camera.width_px = 80;
  camera.height_px = 60;
  camera.fx_px = camera.fy_px = 70.0;
  camera.cx_px = 39.5;
  camera.cy_px = 29.5;
  return camera;
}

TEST(ImageMotion, BlurIsTheMeanOfManyRenderedInstants) {
  const CameraModel camera = small_camera();
  cv::Mat_<cv::Vec3f> colour, instant, mean(60, 80, cv::Vec3f(0, 0, 0));
  cv::Mat_<float> depth, unused;
  look(camera, SE3::Identity(), &colour, &depth);
  constexpr double kOpen = 0.06;
  constexpr int kInstants = 60;
  for (int i = 0; i < kInstants; ++i) {
    const double t = kOpen * ((i + 0.5) / kInstants - 0.5);
    look(camera, moved(kTwist, t), &instant, &unused);
    for (int v = 0; v < 60; ++v)
      for (int u = 0; u < 80; ++u) mean(v, u) += instant(v, u) * (1.0F / kInstants);
  }
  const auto blurred = expose_moving(camera, kTwist, {kOpen, 0.0}, colour, depth);
  double error = 0, effect = 0;
  for (int v = 6; v < 54; ++v)
    for (int u = 6; u < 74; ++u) {
      error += std::pow(blurred(v, u)[0] - mean(v, u)[0], 2);
      effect += std::pow(colour(v, u)[0] - mean(v, u)[0], 2);
    }
  // Sampling between pixels blurs by itself, by up to a sixth of a square pixel of variance: here a
  // third of what 2.5 px of motion do.
  EXPECT_LT(error, 0.25 * effect);
}

TEST(ImageMotion, RowsOfARollingShutterAreOfTheirOwnTime) {
  const CameraModel camera = small_camera();
  cv::Mat_<cv::Vec3f> colour, instant;
  cv::Mat_<float> depth, unused;
  look(camera, SE3::Identity(), &colour, &depth);
  constexpr double kReadout = 0.05;
  const auto rolled = expose_moving(camera, kTwist, {0.0, kReadout}, colour, depth);
  for (const int v : {8, 30, 50}) {
    look(camera, moved(kTwist, kReadout * (v / 59.0 - 0.5)), &instant, &unused);
    for (int u = 8; u < 72; ++u) EXPECT_NEAR(rolled(v, u)[0], instant(v, u)[0], 3.0F) << u;
  }
}

TEST(ImageMotion, LaterDepthIsTheDepthOfTheMovedCamera) {
  const CameraModel camera = small_camera();
  cv::Mat_<cv::Vec3f> colour;
  cv::Mat_<float> depth, expected;
  look(camera, SE3::Identity(), &colour, &depth);
  look(camera, moved(kTwist, 0.02), &colour, &expected);
  const auto later = depth_later(camera, kTwist, 0.02, depth);
  for (int v = 4; v < 56; v += 3)
    for (int u = 4; u < 76; u += 3) EXPECT_NEAR(later(v, u), expected(v, u), 0.004F);
}

TEST(AutoExposure, FollowsTheSceneLateAndInAnyOrderOfTelling) {
  CameraNoise noise;
  AutoExposure a(noise, 1.0 / 30.0), b(noise, 1.0 / 30.0);
  const auto grey = [](int i) { return i < 10 ? 112.0 : 160.0; };
  for (int i = 0; i < 90; ++i) a.tell(i, grey(i));
  for (int i = 89; i >= 0; --i) b.tell(i, grey(i));
  for (int i = 0; i < 90; ++i) EXPECT_EQ(a.factor(i), b.factor(i)) << i;
  EXPECT_NEAR(a.factor(0), 1.0, 1e-9);
  EXPECT_NEAR(a.factor(11), 1.0, 1e-9);  // two frames late
  EXPECT_LT(a.factor(12), 1.0);
  EXPECT_GT(a.factor(14), 0.9);
  EXPECT_NEAR(a.factor(89), 112.0 / 160.0, 0.01);
  noise.with_exposure = false;
  AutoExposure off(noise, 1.0 / 30.0);
  EXPECT_EQ(off.factor(70), noise.exposure);
}

TEST(HandHeldSway, StaysWithinItsBoundsAndIsSmooth) {
  const HandHeld carried;
  const HandHeldSway sway(carried, 3), same(carried, 3), other(carried, 4);
  SE3 last = sway.T_path_base(0.0);
  double lowest = 9, highest = 0;
  for (int i = 1; i < 6000; ++i) {
    const SE3 T = sway.T_path_base(0.01 * i);
    lowest = std::min(lowest, T.translation().z());
    highest = std::max(highest, T.translation().z());
    EXPECT_LT((T.translation() - last.translation()).norm(), 0.01);           // 1 m/s
    EXPECT_LT(log_so3(last.linear().transpose() * T.linear()).norm(), 0.02);  // 2 rad/s
    last = T;
  }
  EXPECT_GE(lowest, carried.height_m - carried.sway_height_m - 1e-9);
  EXPECT_LE(highest, carried.height_m + carried.sway_height_m + 1e-9);
  EXPECT_GT(highest - lowest, 0.08);
  EXPECT_TRUE(sway.T_path_base(7.0).isApprox(same.T_path_base(7.0)));
  EXPECT_FALSE(sway.T_path_base(7.0).isApprox(other.T_path_base(7.0), 1e-3));
}

}  // namespace
}  // namespace fusion_slam
