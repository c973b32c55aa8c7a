// Creation, triangulation, fusion and culling of landmarks and keyframes, one by one.
#include <random>

#include <gtest/gtest.h>

#include "services/visual_odometry/culling.hpp"
#include "services/visual_odometry/landmark_creation.hpp"
#include "services/visual_odometry/landmark_fusion.hpp"
#include "services/visual_odometry/local_mapping.hpp"
#include "services/visual_odometry/triangulation.hpp"
#include "tests/services/visual_odometry/made_up_map.hpp"

namespace fusion_slam {
namespace {

TEST(LandmarkCreation, InformationIsTheInverseOfTheNoise) {
  const CameraModel camera;
  const Eigen::Vector3d p(0.4, -0.3, 1.5);
  const SE3 pose = from_xyz_rpy(1, 0, 0, 0.3, 0.2, 0.1);
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, 1.0);
  const Eigen::Vector2d pixel = camera.project(p);
  const double sigma_m = camera.depth_sigma(p.z());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Vector3d measured =
        camera.unproject(pixel.x() + 0.7 * normal(random), pixel.y() + 0.7 * normal(random),
                         p.z() + sigma_m * normal(random));
    const Eigen::Vector3d error = pose.linear() * (measured - p);
    covariance += error * error.transpose() / kSamples;
  }
  const Eigen::Matrix3d product =
      covariance * observation_information(camera, pose, p, 0.7, sigma_m);
  EXPECT_LT((product - Eigen::Matrix3d::Identity()).norm(), 0.15);
}

TEST(LandmarkCreation, DepthMakesLandmarksAndBearingsWait) {
  MadeUpMap m = make_map(1, 40, 0.0, true, false);
  MapKeyframe keyframe = *m.map.keyframe(1);
  VisualMap map;
  const auto made = insert_keyframe(keyframe, m.camera, {}, m.scales, 0.6, &map);
  EXPECT_EQ(made.size(), 20U);
  EXPECT_TRUE(consistent(map));
  for (std::size_t i = 0; i < keyframe.features->size(); ++i) {
    const std::int64_t id = map.keyframe(1)->landmark_of_feature[i];
    EXPECT_EQ(id != 0, keyframe.features->features[i].depth_m > 0.0F);
    if (id != 0) {
      EXPECT_LT((map.landmark(id)->p_odom - m.points[i]).norm(), 1e-4);
    }
  }
}

TEST(Triangulation, RaysMeetWhereTheObviousSearchFindsThem) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d a(unit(random), 0, 0), b(1.0, unit(random), 0);
    const Eigen::Vector3d p(unit(random), unit(random), 4.0 + unit(random));
    const Eigen::Vector3d to_a = (p - a).normalized();
    Eigen::Vector3d to_b = p - b;
    to_b.x() += 0.01 * unit(random);  // they miss each other by a little
    to_b.normalize();
    const auto met = intersect_rays(a, to_a, b, to_b, 0.01);
    ASSERT_TRUE(met);
    double best = 1e9;
    Eigen::Vector3d obvious = Eigen::Vector3d::Zero();
    for (double s = 0.0; s < 8.0; s += 0.004) {  // along one ray, the nearest point of the other
      const Eigen::Vector3d on_a = a + s * to_a;
      const Eigen::Vector3d on_b = b + to_b * to_b.dot(on_a - b);
      if ((on_a - on_b).norm() >= best) continue;
      best = (on_a - on_b).norm();
      obvious = 0.5 * (on_a + on_b);
    }
    EXPECT_LT((*met - obvious).norm(), 0.01);
  }
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  EXPECT_FALSE(intersect_rays({0, 0, 0}, z, {1, 0, 0}, z, 0.01));
  EXPECT_FALSE(
      intersect_rays({0, 0, 0}, z, {1, 0, 0}, Eigen::Vector3d(0.3, 0, 1).normalized(), 0.01));
}

TEST(Triangulation, BearingsOfTwoKeyframesBecomeLandmarks) {
  MadeUpMap m = make_map(4, 60, 0.0, true, false);
  const VisualOdometryConfig config;
  const int n = triangulate(m.camera, 4, {1, 2, 3}, m.scales, config, &m.map);
  EXPECT_GT(n, 20);
  EXPECT_TRUE(consistent(m.map));
  for (const auto& [id, landmark] : m.map.landmarks()) {
    double nearest = 1e9;
    for (const Eigen::Vector3d& p : m.points)
      nearest = std::min(nearest, (p - landmark.p_odom).norm());
    EXPECT_LT(nearest, 1e-3);
    EXPECT_EQ(landmark.observations.size(), 2U);
  }
}

TEST(LandmarkFusion, WhatWasMadeTwiceBecomesOneAndFreeFeaturesAreLinked) {
  MadeUpMap m = make_map(3, 50, 0.0);
  // Keyframe 3 has its own copy of landmark 5 and does not know landmark 6.
  const auto feature_of = [&](std::int64_t id) {
    for (const Observation& o : m.map.landmark(id)->observations)
      if (o.keyframe == 3) return o.feature;
    return -1;
  };
  const int five = feature_of(5);
  ASSERT_GE(five, 0);
  ASSERT_GE(feature_of(6), 0);
  m.map.unlink(5, 3);
  m.map.unlink(6, 3);
  const std::int64_t copy = m.map.add_landmark(*m.map.landmark(5));
  m.map.landmark(copy)->observations.clear();
  ASSERT_TRUE(m.map.link(copy, 3, five));
  EXPECT_EQ(fuse_landmarks(m.camera, {5, 6, 7}, 3, m.scales, {}, &m.map), 2);
  EXPECT_EQ(m.map.landmark(copy), nullptr);
  EXPECT_EQ(m.map.landmark(5)->observations.size(), 3U);
  EXPECT_EQ(m.map.landmark(6)->observations.size(), 3U);
  EXPECT_TRUE(consistent(m.map));
}

TEST(Culling, PoorAndLonelyLandmarksGo) {
  MadeUpMap m = make_map(2, 30, 0.0);
  Landmark* poor = m.map.landmark(1);
  poor->visible = 40;
  poor->found = 5;
  m.map.unlink(2, 1);  // seen once, long ago
  m.map.unlink(3, 1);
  m.map.landmark(3)->found = 20;  // seen by one keyframe but by many frames
  m.map.unlink(4, 1);
  m.map.landmark(4)->born = 9;  // young
  EXPECT_EQ(cull_landmarks(10, {}, &m.map), 2);
  EXPECT_EQ(m.map.landmark(1), nullptr);
  EXPECT_EQ(m.map.landmark(2), nullptr);
  EXPECT_TRUE(consistent(m.map));
}

TEST(Culling, KeyframesThatShowNothingOfTheirOwnGo) {
  MadeUpMap m = make_map(6, 60, 0.0);
  EXPECT_EQ(cull_keyframes({2, 3, 4, 5}, {}, &m.map), 3);  // three must remain
  EXPECT_TRUE(consistent(m.map));
  EXPECT_EQ(m.map.keyframe(2), nullptr);
  EXPECT_EQ(m.map.keyframe(3), nullptr);
  EXPECT_EQ(m.map.keyframe(4), nullptr);
  EXPECT_EQ(cull_keyframes({5}, {}, &m.map), 0);
}

TEST(Culling, WhatNobodySawAgainDoesNotKeepAKeyframe) {
  MadeUpMap m = make_map(6, 60, 0.0);
  for (std::int64_t landmark = 1; landmark <= 40; ++landmark) m.map.unlink(landmark, 2);
  EXPECT_EQ(cull_keyframes({2}, {}, &m.map), 1);
  // A keyframe of which nothing is known any more is no copy of others either.
  for (std::int64_t landmark = 1; landmark <= 60; ++landmark) m.map.unlink(landmark, 3);
  EXPECT_EQ(cull_keyframes({3}, {}, &m.map), 0);
}

TEST(LocalMapping, ForgetsRedundantKeyframesButNoneWhoseEdgeIsOpen) {
  MadeUpMap m = make_map(14, 120, 1.0);
  const VisualOdometryConfig config;
  const MappingJob job = make_mapping_job(m.map, 14, config);
  EXPECT_EQ(job.cullable, (std::vector<std::int64_t>{2, 3}));  // 10 newer ones; 1 is the origin
  const MappingResult result = improve_map(m.camera, job, m.scales, config);
  EXPECT_EQ(result.n_keyframes_culled, 2);
  m.map.put_back(job.part, result.part);
  EXPECT_EQ(m.map.keyframe(2), nullptr);
  EXPECT_EQ(m.map.keyframe(3), nullptr);
  EXPECT_EQ(m.map.keyframes().size(), 12U);
  EXPECT_TRUE(consistent(m.map));
}

TEST(LocalMapping, TheThreadGivesWhatTheFunctionGives) {
  MadeUpMap m = make_map(6, 120, 1.0, true);
  const VisualOdometryConfig config;
  const MappingJob job = make_mapping_job(m.map, 6, config);
  EXPECT_EQ(job.moving.size(), 6U);
  VisualMap direct = m.map;
  direct.put_back(job.part, improve_map(m.camera, job, m.scales, config).part);
  LocalMapping mapping(m.camera, m.scales, config);
  mapping.start(job);
  EXPECT_TRUE(mapping.busy());
  mapping.finish(&m.map);
  EXPECT_FALSE(mapping.busy());
  EXPECT_TRUE(consistent(m.map));
  ASSERT_EQ(direct.landmarks().size(), m.map.landmarks().size());
  for (const auto& [id, keyframe] : direct.keyframes())
    EXPECT_EQ(keyframe.T_odom_camera.matrix(), m.map.keyframe(id)->T_odom_camera.matrix());
}

}  // namespace
}  // namespace fusion_slam
