#include "libs/camera/depth_registration.hpp"

#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

CameraModel small_camera(int width, int height, double f_px) {
  CameraModel camera;
  camera.width_px = width;
  camera.height_px = height;
  camera.fx_px = camera.fy_px = f_px;
  camera.cx_px = 0.5 * (width - 1);
  camera.cy_px = 0.5 * (height - 1);
  return camera;
}

// The definition, pixel of colour by pixel of colour: the nearest of all plates whose image, grown
// by the overlap, covers the centre.
cv::Mat register_slowly(const cv::Mat& depth_mm, const DepthRegistration& r, double overlap_px) {
  cv::Mat result(r.colour_camera.height_px, r.colour_camera.width_px, CV_16UC1, cv::Scalar(0));
  for (int y = 0; y < result.rows; ++y)
    for (int x = 0; x < result.cols; ++x) {
      double nearest_mm = 1e9;
      for (int v = 0; v < depth_mm.rows; ++v)
        for (int u = 0; u < depth_mm.cols; ++u) {
          const double z = 0.001 * depth_mm.at<std::uint16_t>(v, u);
          if (z == 0.0) continue;
          const Eigen::Vector3d a =
              r.T_colour_depth * r.depth_camera.unproject(u - 0.5, v - 0.5, z);
          const Eigen::Vector3d b =
              r.T_colour_depth * r.depth_camera.unproject(u + 0.5, v + 0.5, z);
          const Eigen::Vector2d pa = r.colour_camera.project(a);
          const Eigen::Vector2d pb = r.colour_camera.project(b);
          const bool covers = pa.x() - overlap_px <= x && x <= pb.x() + overlap_px &&
                              pa.y() - overlap_px <= y && y <= pb.y() + overlap_px;
          if (covers) nearest_mm = std::min(nearest_mm, std::round(500.0 * (a.z() + b.z())));
        }
      if (nearest_mm < 1e9) result.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(nearest_mm);
    }
  return result;
}

int count_different(const cv::Mat& a, const cv::Mat& b) {
  int n = 0;
  for (int v = 0; v < a.rows; ++v)
    for (int u = 0; u < a.cols; ++u)
      n += a.at<std::uint16_t>(v, u) != b.at<std::uint16_t>(v, u) ? 1 : 0;
  return n;
}

TEST(RegisterDepth, EqualsTheSlowDefinitionOnRandomScenes) {
  std::mt19937 random(7);
  for (const double colour_f : {27.0, 30.0, 55.0}) {  // smaller, equal, larger image
    DepthRegistration r{small_camera(40, 30, 33.0), small_camera(44, 32, colour_f),
                        SE3::Identity()};
    r.T_colour_depth.translation() = Eigen::Vector3d(-0.025, 0.004, 0.01);
    cv::Mat depth(30, 40, CV_16UC1);
    for (int v = 0; v < depth.rows; ++v)
      for (int u = 0; u < depth.cols; ++u) {
        const bool near = (u / 9 + v / 7) % 2 == 0;
        const auto noise = static_cast<int>(random() % 40);
        const int mm = random() % 11 == 0 ? 0 : (near ? 700 : 2300) + noise;
        depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(mm);
      }
    EXPECT_EQ(count_different(register_depth(depth, r), register_slowly(depth, r, 0.10)), 0)
        << "colour f " << colour_f;
  }
}

TEST(RegisterDepth, SameCameraChangesNothing) {
  const CameraModel camera = small_camera(16, 12, 20.0);
  cv::Mat depth(12, 16, CV_16UC1, cv::Scalar(1500));
  depth.at<std::uint16_t>(5, 5) = 0;
  EXPECT_EQ(count_different(register_depth(depth, {camera, camera, SE3::Identity()}), depth), 0);
}

TEST(RegisterDepth, MagnifiedSlantedWallHasNoHoles) {
  DepthRegistration r{small_camera(80, 60, 66.0), small_camera(160, 120, 160.0), SE3::Identity()};
  r.T_colour_depth.translation().x() = -0.025;
  cv::Mat depth(60, 80, CV_16UC1);
  for (int v = 0; v < 60; ++v)
    for (int u = 0; u < 80; ++u)
      depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(900 + 20 * u);
  const cv::Mat registered = register_depth(depth, r);
  int holes = 0;
  for (int y = 10; y < 110; ++y)
    for (int x = 20; x < 140; ++x) holes += registered.at<std::uint16_t>(y, x) == 0 ? 1 : 0;
  EXPECT_EQ(holes, 0);
}

TEST(RegisterDepth, NearEdgeGrowsByAtMostHalfADepthPixel) {
  DepthRegistration r{small_camera(64, 48, 60.0), small_camera(64, 48, 120.0), SE3::Identity()};
  cv::Mat depth(48, 64, CV_16UC1, cv::Scalar(3000));
  depth(cv::Rect(28, 20, 8, 8)).setTo(1000);  // borders at 27.5 and 35.5 in the depth image
  const cv::Mat registered = register_depth(depth, r);
  for (int x = 0; x < 64; ++x) {
    const double u = (x - 31.5) / 2.0 + 31.5;
    const bool near = registered.at<std::uint16_t>(24, x) == 1000;
    if (u > 27.6 && u < 35.4) {
      EXPECT_TRUE(near) << x;
    }
    if (u < 27.4 || u > 35.6) {
      EXPECT_FALSE(near) << x;
    }
  }
}

TEST(RegisterDepth, RefusesAnotherSizeOrType) {
  const CameraModel camera = small_camera(16, 12, 20.0);
  const DepthRegistration r{camera, camera, SE3::Identity()};
  EXPECT_THROW(register_depth(cv::Mat(12, 15, CV_16UC1), r), std::invalid_argument);
  EXPECT_THROW(register_depth(cv::Mat(12, 16, CV_8UC1), r), std::invalid_argument);
}

}  // namespace
}  // namespace fusion_slam
