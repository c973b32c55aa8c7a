#include "libs/features/feature_depth.hpp"

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

namespace fusion_slam {
namespace {

TEST(FeatureDepth, MedianOfTheNeighbours) {
  cv::Mat depth(40, 40, CV_16UC1, cv::Scalar(2000));
  depth.at<std::uint16_t>(20, 20) = 2012;
  depth.at<std::uint16_t>(21, 20) = 0;
  EXPECT_DOUBLE_EQ(depth_at(depth, {}, 20.2, 19.9), 2.0);
}

TEST(FeatureDepth, NothingOnAnEdge) {
  cv::Mat depth(40, 40, CV_16UC1, cv::Scalar(2000));
  depth.colRange(21, 40).setTo(2600);
  EXPECT_EQ(depth_at(depth, {}, 20, 20), 0.0);
  EXPECT_DOUBLE_EQ(depth_at(depth, {}, 18, 20), 2.0);
  EXPECT_DOUBLE_EQ(depth_at(depth, {}, 23, 20), 2.6);
}

TEST(FeatureDepth, NothingFromFewOrImpossibleReadings) {
  cv::Mat depth(40, 40, CV_16UC1, cv::Scalar(0));
  depth(cv::Rect(20, 20, 3, 1)).setTo(1500);
  EXPECT_EQ(depth_at(depth, {}, 21, 20), 0.0);
  depth.setTo(100);  // nearer than the camera can see
  EXPECT_EQ(depth_at(depth, {}, 21, 20), 0.0);
}

TEST(FeatureDepth, CornersOfTheImageAndBeyond) {
  const cv::Mat depth(40, 40, CV_16UC1, cv::Scalar(1500));
  EXPECT_DOUBLE_EQ(depth_at(depth, {}, 0, 0), 1.5);
  EXPECT_DOUBLE_EQ(depth_at(depth, {}, 39, 39), 1.5);
  EXPECT_EQ(depth_at(depth, {}, -10, 60), 0.0);
}

TEST(FeatureDepth, UndistortIsTheInverseOfTheLens) {
  CameraModel camera;
  camera.distortion = {0.2, -0.3, 0.001, -0.002, 0.05};
  FeatureSet set;
  std::vector<Eigen::Vector2d> ideal;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d p(-0.5 + 0.05 * i, 0.4 - 0.04 * i, 1.0);
    ideal.push_back(camera.project(p));
    std::vector<cv::Point2d> pixel;
    cv::projectPoints(
        std::vector<cv::Point3d>{{p.x(), p.y(), p.z()}}, cv::Vec3d(), cv::Vec3d(),
        cv::Matx33d(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1),
        cv::Mat(1, 5, CV_64F, camera.distortion.data()), pixel);
    Feature f;
    f.u_px = static_cast<float>(pixel[0].x);
    f.v_px = static_cast<float>(pixel[0].y);
    set.features.push_back(f);
  }
  undistort(camera, &set);
  for (std::size_t i = 0; i < ideal.size(); ++i) {
    EXPECT_NEAR(set.features[i].u_px, ideal[i].x(), 0.05);
    EXPECT_NEAR(set.features[i].v_px, ideal[i].y(), 0.05);
  }
}

}  // namespace
}  // namespace fusion_slam
