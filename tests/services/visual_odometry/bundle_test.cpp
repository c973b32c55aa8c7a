#include <random>

#include <gtest/gtest.h>

#include "services/visual_odometry/bundle_costs.hpp"
#include "services/visual_odometry/local_bundle_adjustment.hpp"
#include "tests/services/visual_odometry/made_up_map.hpp"
#include "tests/support/numeric_jacobians.hpp"

namespace fusion_slam {
namespace {

TEST(BundleCosts, JacobiansAgreeWithNumericOnes) {
  const CameraModel camera;
  const PoseManifold manifold;
  for (const double depth_m : {2.1, 0.0}) {
    Correspondence seen;
    seen.pixel = {300.0, 200.0};
    seen.pixel_sigma = 0.7;
    seen.depth_m = depth_m;
    seen.depth_sigma_m = 0.02;
    const ObservationCost cost(camera, seen);
    PoseBlock pose = to_block(from_xyz_rpy(0.1, 0.2, -0.1, 0.1, -0.2, 0.3));
    std::array<double, 3> point{0.2, 0.1, 2.0};
    std::array<double, 21> by_pose{};
    std::array<double, 9> by_point{};
    Eigen::Vector3d r;
    const auto evaluate = [&](double** jacobians) {
      const double* parameters[] = {pose.data(), point.data()};
      EXPECT_TRUE(cost.Evaluate(parameters, r.data(), jacobians));
      return r;
    };
    double* jacobians[] = {by_pose.data(), by_point.data()};
    evaluate(jacobians);
    constexpr double kStep = 1e-6;
    for (int i = 0; i < 6; ++i) {
      const PoseBlock at = pose;
      Vector6d delta = Vector6d::Zero();
      Eigen::Vector3d ends[2];
      for (const int side : {0, 1}) {
        delta(i) = side == 0 ? -kStep : kStep;
        manifold.Plus(at.data(), delta.data(), pose.data());
        ends[side] = evaluate(nullptr);
      }
      pose = at;
      for (int row = 0; row < 3; ++row)
        EXPECT_NEAR((ends[1] - ends[0])(row) / (2 * kStep), by_pose[row * 7 + i], 1e-3);
    }
    for (int i = 0; i < 3; ++i) {
      const auto at = point;
      point[i] = at[i] + kStep;
      const Eigen::Vector3d plus = evaluate(nullptr);
      point[i] = at[i] - kStep;
      const Eigen::Vector3d minus = evaluate(nullptr);
      point = at;
      for (int row = 0; row < 3; ++row)
        EXPECT_NEAR((plus - minus)(row) / (2 * kStep), by_point[row * 3 + i], 1e-3);
    }
  }
}

TEST(BundleCosts, PlanarPriorJacobianAgreesWithNumericOne) {
  PlanarPrior prior;
  prior.T_base_camera = from_xyz_rpy(0.1, -0.02, 0.35, -1.7, 0.05, -1.5);
  for (const double tilt : {0.0, 0.01, -0.4}) {
    const SE3 T_odom_base = from_xyz_rpy(0.3, -0.2, 0.02, tilt, -2.0 * tilt, 0.7);
    expect_jacobians_match(PlanarPriorCost(prior), {to_block(T_odom_base * prior.T_base_camera)});
  }
}

void disturb(VisualMap* map, std::int64_t but) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (const auto& [id, keyframe] : map->keyframes()) {
    if (id == but) continue;
    Vector6d xi;
    for (int i = 0; i < 6; ++i) xi(i) = 0.01 * normal(random);
    map->keyframe(id)->T_odom_camera = retract(keyframe.T_odom_camera, xi);
  }
  for (const auto& [id, landmark] : map->landmarks())
    map->landmark(id)->p_odom +=
        0.02 * Eigen::Vector3d(normal(random), normal(random), normal(random));
}

TEST(LocalBundleAdjustment, FindsTheTruthOfExactViewsAlsoWithBearingsOnly) {
  for (const bool bearings : {false, true}) {
    MadeUpMap m = make_map(5, 80, 0.0, bearings);
    disturb(&m.map, 1);
    VisualOdometryConfig config;
    config.bundle_iterations = 30;
    const BundleResult result = adjust_bundle(m.camera, {2, 3, 4, 5}, m.scales, config, &m.map);
    EXPECT_EQ(result.n_poses, 4);
    EXPECT_EQ(result.n_outliers, 0);
    EXPECT_LT(result.final_cost, 1e-2 * result.initial_cost);
    for (const auto& [id, T] : m.poses)
      EXPECT_LT(local(T, m.map.keyframe(id)->T_odom_camera).norm(), 2e-3) << id;
    EXPECT_EQ(m.map.keyframe(1)->T_odom_camera.matrix(), m.poses.at(1).matrix());
  }
}

TEST(LocalBundleAdjustment, AveragesNoiseAndRefusesWhatIsWrong) {
  MadeUpMap m = make_map(6, 150, 1.0);
  // Feature 0 of keyframe 4 looks elsewhere.
  auto wrong = std::make_shared<FeatureSet>(*m.map.keyframe(4)->features);
  wrong->features[0].u_px += 25.0F;
  const std::int64_t victim = m.map.keyframe(4)->landmark_of_feature[0];
  m.map.keyframe(4)->features = wrong;
  disturb(&m.map, 1);
  const VisualOdometryConfig config;
  VisualMap again = m.map;
  const BundleResult result = adjust_bundle(m.camera, {2, 3, 4, 5, 6}, m.scales, config, &m.map);
  EXPECT_GE(result.n_outliers, 1);
  EXPECT_LE(result.n_outliers, 8);  // of about 800 good ones: 99.9 %
  for (const Observation& o : m.map.landmark(victim)->observations) EXPECT_NE(o.keyframe, 4);
  EXPECT_TRUE(consistent(m.map));
  for (const auto& [id, T] : m.poses)
    EXPECT_LT(local(T, m.map.keyframe(id)->T_odom_camera).norm(), 0.006) << id;
  adjust_bundle(m.camera, {2, 3, 4, 5, 6}, m.scales, config, &again);
  for (const auto& [id, keyframe] : again.keyframes())
    EXPECT_EQ(keyframe.T_odom_camera.matrix(), m.map.keyframe(id)->T_odom_camera.matrix());
}

// Before a bare wall: three features are left, all wrong in the same way.
TEST(LocalBundleAdjustment, WhereFeaturesFailTheTieBetweenSurfacesHolds) {
  for (const bool tied : {false, true}) {
    MadeUpMap m = make_map(5, 80, 0.0);
    auto wrong = std::make_shared<FeatureSet>(*m.map.keyframe(5)->features);
    const std::vector<std::int64_t> seen = m.map.keyframe(5)->landmark_of_feature;
    for (std::size_t i = 3; i < seen.size(); ++i) m.map.unlink(seen[i], 5);
    for (std::size_t i = 0; i < 3; ++i) wrong->features[i].u_px += 8.0F;
    m.map.keyframe(5)->features = wrong;
    if (tied) {
      SurfaceTie& tie = m.map.keyframe(5)->tie;
      tie.keyframe = 4;
      tie.T_earlier_camera = m.poses.at(4).inverse() * m.poses.at(5);
      tie.information.diagonal() << 0.0, 1e6, 1e6, 1e6, 1e6, 0.0;  // sliding and roll stay open
    }
    const BundleResult result = adjust_bundle(m.camera, {5}, m.scales, {}, &m.map);
    EXPECT_EQ(result.n_poses, 1);
    const Vector6d off = local(m.poses.at(5), m.map.keyframe(5)->T_odom_camera);
    const double turned_rad = off.tail<3>().head<2>().norm();
    EXPECT_EQ(turned_rad < 0.002, tied) << turned_rad;
    EXPECT_EQ(turned_rad > 0.005, !tied) << turned_rad;
  }
}

// The surfaces of two keyframes alone hold them together.
TEST(LocalBundleAdjustment, ATieNeedsNoFeatures) {
  MadeUpMap m = make_map(3, 80, 0.0);
  const std::vector<std::int64_t> seen = m.map.keyframe(3)->landmark_of_feature;
  for (const std::int64_t id : seen) m.map.unlink(id, 3);
  SurfaceTie& tie = m.map.keyframe(3)->tie;
  tie = {2, m.poses.at(2).inverse() * m.poses.at(3), 1e6 * Matrix6d::Identity()};
  disturb(&m.map, 1);
  VisualOdometryConfig config;
  config.bundle_iterations = 30;
  adjust_bundle(m.camera, {2, 3}, m.scales, config, &m.map);
  EXPECT_LT(local(m.poses.at(3), m.map.keyframe(3)->T_odom_camera).norm(), 3e-3);
  // A tie to a keyframe that is gone counts for nothing.
  m.map.keyframe(3)->tie.keyframe = 99;
  const SE3 before = m.map.keyframe(3)->T_odom_camera;
  adjust_bundle(m.camera, {2, 3}, m.scales, config, &m.map);
  EXPECT_EQ(m.map.keyframe(3)->T_odom_camera.matrix(), before.matrix());
}

}  // namespace
}  // namespace fusion_slam
