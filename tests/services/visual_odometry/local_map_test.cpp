#include "services/visual_odometry/local_map.hpp"

#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

const std::vector<double> kScales{1.0, 1.2};

FeatureSet one_feature(const CameraModel& camera, const Eigen::Vector3d& p_camera,
                       bool depth = true) {
  const Eigen::Vector2d pixel = camera.project(p_camera);
  FeatureSet set;
  Feature f;
  f.u_px = static_cast<float>(pixel.x());
  f.v_px = static_cast<float>(pixel.y());
  f.depth_m = depth ? static_cast<float>(p_camera.z()) : 0.0F;
  set.features.push_back(f);
  set.descriptors.emplace_back();
  return set;
}

void add(LocalMap* map, std::int64_t id, const CameraModel& camera, const SE3& T_odom_camera,
         const FeatureSet& set, const std::vector<double>& scales, double pixel_sigma,
         std::vector<std::int64_t> points, int keep) {
  map->add_keyframe(id, camera, T_odom_camera, set, scales, pixel_sigma, keep, &points);
}

TEST(LocalMap, MakesPointsOnlyFromDepth) {
  const CameraModel camera;
  LocalMap map;
  add(&map, 1, camera, SE3::Identity(), one_feature(camera, {0.1, 0.2, 2.0}, false), kScales, 0.7,
      {0}, 5);
  EXPECT_TRUE(map.empty());
  const SE3 pose = from_xyz_rpy(1, 2, 3, 0.1, 0.2, 0.3);
  add(&map, 2, camera, pose, one_feature(camera, {0.1, 0.2, 2.0}), kScales, 0.7, {0}, 5);
  ASSERT_EQ(map.points().size(), 1U);
  const Eigen::Vector3d p = map.points().begin()->second.p_odom;
  EXPECT_LT((p - pose * Eigen::Vector3d(0.1, 0.2, 2.0)).norm(), 1e-4);
}

TEST(LocalMap, RepeatedMeasurementsAverageByTheirInformation) {
  const CameraModel camera;
  const Eigen::Vector3d p(0.1, -0.1, 2.0);
  LocalMap map;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, camera.depth_sigma(2.0));
  add(&map, 1, camera, SE3::Identity(), one_feature(camera, p), kScales, 0.7, {0}, 200);
  const std::int64_t id = map.points().begin()->first;
  const Eigen::Matrix3d once = map.points().at(id).information;
  for (int k = 2; k <= 100; ++k)
    add(&map, k, camera, SE3::Identity(), one_feature(camera, p * ((2.0 + noise(random)) / 2.0)),
        kScales, 0.7, {id}, 200);
  EXPECT_EQ(map.points().size(), 1U);
  EXPECT_LT((map.points().at(id).p_odom - p).norm(), 3.0 * camera.depth_sigma(2.0) / 10.0);
  EXPECT_NEAR(map.points().at(id).information.trace() / once.trace(), 100.0, 3.0);
}

TEST(LocalMap, InformationIsTheInverseOfTheNoise) {
  const CameraModel camera;
  const Eigen::Vector3d p(0.4, -0.3, 1.5);
  const SE3 pose = from_xyz_rpy(1, 0, 0, 0.3, 0.2, 0.1);
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, 1.0);
  const Eigen::Vector2d pixel = camera.project(p);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Vector3d measured =
        camera.unproject(pixel.x() + 0.7 * normal(random), pixel.y() + 0.7 * normal(random),
                         p.z() + camera.depth_sigma(p.z()) * normal(random));
    const Eigen::Vector3d error = pose.linear() * (measured - p);
    covariance += error * error.transpose() / kSamples;
  }
  const Eigen::Matrix3d product = covariance * observation_information(camera, pose, p, 0.7);
  EXPECT_LT((product - Eigen::Matrix3d::Identity()).norm(), 0.15);
}

TEST(LocalMap, ForgetsWhatIsOldOrNeverFound) {
  const CameraModel camera;
  LocalMap map;
  add(&map, 1, camera, SE3::Identity(), one_feature(camera, {0, 0, 2.0}), kScales, 0.7, {0}, 3);
  for (int k = 2; k <= 3; ++k)
    add(&map, k, camera, SE3::Identity(), one_feature(camera, {0.1 * k, 0, 2.0}), kScales, 0.7, {0},
        3);
  EXPECT_EQ(map.points().size(), 3U);
  for (int i = 0; i < 20; ++i) map.count_visible(2);
  for (int i = 0; i < 20; ++i) map.count_visible(3);
  for (int i = 0; i < 10; ++i) map.count_found(3);
  add(&map, 4, camera, SE3::Identity(), {}, kScales, 0.7, {}, 3);
  ASSERT_EQ(map.points().size(), 1U);
  EXPECT_EQ(map.points().begin()->first, 3);
}

}  // namespace
}  // namespace fusion_slam
