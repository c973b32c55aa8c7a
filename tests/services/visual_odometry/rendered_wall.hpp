// An RGB-D camera in front of a textured wall, by homography: exact colour, depth and pose.
#pragma once

#include <random>

#include <opencv2/imgproc.hpp>

#include "libs/camera/camera_model.hpp"
#include "libs/camera/rgbd_frame.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

// The wall is the plane z = 0 of world, 8 m x 6 m around the origin; cameras stand at negative z
// and look along +z.
class RenderedWall {
 public:
  explicit RenderedWall(unsigned seed = 1) : texture_(kHeight, kWidth, CV_8UC3) {
    std::mt19937 random(seed);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        texture_.at<cv::Vec3b>(y, x) = cv::Vec3b::all(random() % 256);
    cv::GaussianBlur(texture_, texture_, cv::Size(0, 0), 2.5);
    cv::normalize(texture_, texture_, 0, 255, cv::NORM_MINMAX);
  }

  RgbdFrame see(const CameraModel& camera, const SE3& T_world_camera, std::int64_t utime_us) const {
    const SE3 T_camera_world = T_world_camera.inverse();
    // Texture pixel -> wall point -> image pixel.
    Eigen::Matrix3d wall_of_texture;
    wall_of_texture << kPixel_m, 0, -kPixel_m * kWidth / 2, 0, kPixel_m, -kPixel_m * kHeight / 2, 0,
        0, 1;
    Eigen::Matrix3d camera_of_wall;
    camera_of_wall << T_camera_world.linear().col(0), T_camera_world.linear().col(1),
        T_camera_world.translation();
    Eigen::Matrix3d K;
    K << camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1;
    const Eigen::Matrix3d H = K * camera_of_wall * wall_of_texture;
    cv::Matx33d warp;
    for (int i = 0; i < 9; ++i) warp(i / 3, i % 3) = H(i / 3, i % 3);
    RgbdFrame frame;
    frame.utime_us = utime_us;
    cv::warpPerspective(texture_, frame.colour_bgr, warp, {camera.width_px, camera.height_px});
    frame.depth_mm.create(camera.height_px, camera.width_px, CV_16UC1);
    const Eigen::Vector3d normal = T_camera_world.linear().col(2);
    const double offset = normal.dot(T_camera_world.translation());
    for (int v = 0; v < camera.height_px; ++v)
      for (int u = 0; u < camera.width_px; ++u) {
        const double z_m = offset / normal.dot(camera.unproject(u, v, 1.0));
        frame.depth_mm.at<std::uint16_t>(v, u) =
            cv::saturate_cast<std::uint16_t>(z_m > 0.0 ? 1000.0 * z_m : 0.0);
      }
    return frame;
  }

 private:
  static constexpr int kWidth = 1600;
  static constexpr int kHeight = 1200;
  static constexpr double kPixel_m = 0.005;
  cv::Mat texture_;
};

// A smooth walk along the wall that comes back.
inline SE3 walk(int step) {
  return from_xyz_rpy(0.5 * std::sin(0.06 * step), 0.15 * std::sin(0.1 * step), -1.6 + 0.003 * step,
                      0.1 * std::sin(0.05 * step), 0.15 * std::sin(0.07 * step),
                      0.1 * std::sin(0.03 * step));
}

// A robot that is all camera, mounted so.
inline RobotModel robot_with(const SE3& T_base_camera) {
  RobotModel robot;
  robot.has_camera = true;
  robot.T_base_camera = T_base_camera;
  return robot;
}

inline RgbdFrame blank(const CameraModel& camera, std::int64_t utime_us) {
  const cv::Size size(camera.width_px, camera.height_px);
  return {utime_us, cv::Mat(size, CV_8UC3, cv::Scalar::all(40)),
          cv::Mat(size, CV_16UC1, cv::Scalar(1500))};
}

}  // namespace fusion_slam
