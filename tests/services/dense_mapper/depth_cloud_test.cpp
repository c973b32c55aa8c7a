#include "services/dense_mapper/depth_cloud.hpp"

#include <gtest/gtest.h>

#include "tests/services/dense_mapper/synthetic_room.hpp"

namespace fusion_slam {
namespace {

RgbdFrame flat(const CameraModel& camera, std::uint16_t depth_mm) {
  RgbdFrame frame;
  frame.colour_bgr = cv::Mat(camera.height_px, camera.width_px, CV_8UC3, cv::Scalar(1, 2, 3));
  frame.depth_mm = cv::Mat(camera.height_px, camera.width_px, CV_16UC1, cv::Scalar(depth_mm));
  return frame;
}

TEST(DepthCloud, PointsAreEquation2) {
  const CameraModel camera = small_camera();
  const DepthCloud cloud = make_depth_cloud(flat(camera, 2000), camera, 0.05, {});
  ASSERT_GT(cloud.points.size(), 1000U);
  // The first sampled pixel that is not at the image's rim: (2, 2).
  const Eigen::Vector3f& p = cloud.points.front().p_m;
  EXPECT_NEAR(p.x(), (2 - 79.5) / 131.0 * 2.0, 1e-5);
  EXPECT_NEAR(p.y(), (2 - 59.5) / 131.0 * 2.0, 1e-5);
  EXPECT_FLOAT_EQ(p.z(), 2.0F);
  EXPECT_EQ(cloud.points.front().r, 3);
  EXPECT_EQ(cloud.points.front().b, 1);
  ASSERT_FALSE(cloud.surfaces.empty());
  EXPECT_NEAR(cloud.surfaces.front().normal.z(), -1.0, 1e-5);
}

TEST(DepthCloud, OutOfTrustedRangeIsLeftOut) {
  const CameraModel camera = small_camera();
  EXPECT_NEAR(trusted_depth_m(camera, 0.05), 5.07, 0.01);
  EXPECT_NEAR(camera.depth_sigma(trusted_depth_m(camera, 0.05)), 0.05, 1e-9);
  for (const int depth_mm : {0, 200, 5200, 9000, 65535})
    EXPECT_TRUE(
        make_depth_cloud(flat(camera, static_cast<std::uint16_t>(depth_mm)), camera, 0.05, {})
            .points.empty());
}

TEST(DepthCloud, EdgesAndFlyingPixelsAreLeftOut) {
  const CameraModel camera = small_camera();
  RgbdFrame frame = flat(camera, 3000);
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 80; u < camera.width_px; ++u) frame.depth_mm.at<std::uint16_t>(v, u) = 1500;
    frame.depth_mm.at<std::uint16_t>(v, 79) = 2250;  // mixed
    frame.depth_mm.at<std::uint16_t>(v, 80) = 2000;
  }
  const DepthCloud cloud = make_depth_cloud(frame, camera, 0.05, {});
  EXPECT_GT(cloud.points.size(), 800U);
  for (const ColouredPoint& p : cloud.points)
    EXPECT_TRUE(p.p_m.z() == 3.0F || p.p_m.z() == 1.5F) << p.p_m.z();
}

TEST(DepthCloud, SteepFloorStays) {
  const CameraModel camera = small_camera();
  SE3 T_room_camera = SE3::Identity();
  T_room_camera.linear() = optical_to_body();
  T_room_camera.translation() =
      Eigen::Vector3d(-1.5, 2.0, 0.5);  // beside the box; floor from 1.1 m to 4 m
  const DepthCloud cloud =
      make_depth_cloud(render_room(T_room_camera, camera, 1), camera, 0.05, {});
  int far_floor = 0;
  for (const ColouredPoint& p : cloud.points) {
    const Eigen::Vector3d q = T_room_camera * p.p_m.cast<double>();
    far_floor += std::abs(q.z()) < 0.01 && p.p_m.z() > 2.5 ? 1 : 0;
  }
  EXPECT_GT(far_floor, 50);
}

}  // namespace
}  // namespace fusion_slam
