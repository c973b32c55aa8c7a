#include "libs/features/planar_prior.hpp"

#include <gtest/gtest.h>

#include "libs/features/pose_refiner.hpp"
#include "tests/libs/features/made_up_matches.hpp"

namespace fusion_slam {
namespace {

PlanarPrior made_up_prior() {
  PlanarPrior prior;
  prior.T_base_camera = from_xyz_rpy(0.1, -0.02, 0.35, -1.7, 0.05, -1.5);
  return prior;
}

TEST(PlanarPrior, JacobianAgreesWithNumericDerivative) {
  const PlanarPrior prior = made_up_prior();
  const SE3 pose = from_xyz_rpy(0.3, -0.2, 0.5, 0.1, -0.4, 0.7) * prior.T_base_camera;
  PlanarJacobian J;
  planar_prior_residual(prior, pose, &J);
  for (int k = 0; k < 6; ++k) {
    constexpr double kStep = 1e-6;
    const Vector6d step = Vector6d::Unit(k) * kStep;
    const Eigen::Vector3d numeric = (planar_prior_residual(prior, retract(pose, step), nullptr) -
                                     planar_prior_residual(prior, retract(pose, -step), nullptr)) /
                                    (2.0 * kStep);
    EXPECT_LT((J.col(k) - numeric).norm(), 1e-5 * (1.0 + numeric.norm())) << "parameter " << k;
  }
}

TEST(PlanarPrior, IsZeroWhereverTheBaseStandsOnTheFloor) {
  const PlanarPrior prior = made_up_prior();
  const SE3 pose = from_xyz_rpy(3.0, -7.0, 0.0, 0.0, 0.0, 2.2) * prior.T_base_camera;
  EXPECT_LT(planar_prior_residual(prior, pose, nullptr).norm(), 1e-9);
  const SE3 above = from_xyz_rpy(3.0, -7.0, 2.0 * prior.sigma_z_m, 0.0, 0.0, 2.2);
  EXPECT_NEAR(planar_prior_residual(prior, above * prior.T_base_camera, nullptr).x(), 2.0, 1e-9);
}

// Three matches leave a pose open; on the floor they don't.
TEST(PlanarPrior, HoldsAPoseThatFewFeaturesLeaveOpen) {
  const CameraModel camera;
  RefineConfig config;
  config.planar = made_up_prior();
  const SE3 T_odom_base = from_xyz_rpy(0.4, -0.3, 0.0, 0.0, 0.0, 0.5);
  const SE3 pose = T_odom_base * config.planar->T_base_camera;
  std::mt19937 random(5);
  const auto matches = made_up_matches(camera, pose, 4, 0, 1.0, &random);
  Vector6d off;
  off << 0.02, -0.02, 0.02, 0.02, -0.01, 0.02;
  const RefinedPose found = refine_pose(camera, matches, retract(pose, off), config);
  const SE3 base = found.T_reference_camera * config.planar->T_base_camera.inverse();
  EXPECT_NEAR(base.translation().z(), 0.0, 0.01);
  EXPECT_GT(base.linear()(2, 2), std::cos(0.01));
}

}  // namespace
}  // namespace fusion_slam
