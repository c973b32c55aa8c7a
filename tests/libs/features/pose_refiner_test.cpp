#include "libs/features/pose_refiner.hpp"

#include <gtest/gtest.h>

#include "tests/libs/features/made_up_matches.hpp"

namespace fusion_slam {
namespace {

const SE3 kPose = from_xyz_rpy(0.3, -0.2, 0.5, 0.1, -0.4, 0.7);

TEST(PoseRefiner, JacobianAgreesWithNumericDerivative) {
  const CameraModel camera;
  std::mt19937 random(3);
  for (const Correspondence& match : made_up_matches(camera, kPose, 30, 0, 3.0, &random)) {
    Eigen::Vector3d r;
    ResidualJacobian J;
    ASSERT_TRUE(pose_residual(camera, match, kPose, &r, &J));
    for (int k = 0; k < 6; ++k) {
      constexpr double kStep = 1e-6;
      Eigen::Vector3d plus;
      Eigen::Vector3d minus;
      ASSERT_TRUE(
          pose_residual(camera, match, retract(kPose, Vector6d::Unit(k) * kStep), &plus, nullptr));
      ASSERT_TRUE(pose_residual(camera, match, retract(kPose, Vector6d::Unit(k) * -kStep), &minus,
                                nullptr));
      const Eigen::Vector3d numeric = (plus - minus) / (2.0 * kStep);
      EXPECT_LT((J.col(k) - numeric).norm(), 1e-5 * (1.0 + numeric.norm())) << "parameter " << k;
    }
  }
}

TEST(PoseRefiner, PointBehindTheCameraHasNoResidual) {
  const CameraModel camera;
  Correspondence behind;
  behind.p_reference = {0.0, 0.0, -1.0};
  Eigen::Vector3d r;
  EXPECT_FALSE(pose_residual(camera, behind, SE3::Identity(), &r, nullptr));
}

TEST(PoseRefiner, FindsThePoseDespiteWrongMatches) {
  const CameraModel camera;
  std::mt19937 random(5);
  const auto matches = made_up_matches(camera, kPose, 200, 50, 1.0, &random);
  Vector6d off;
  off << 0.05, -0.04, 0.05, 0.03, -0.02, 0.03;
  const RefinedPose found = refine_pose(camera, matches, retract(kPose, off));
  const Vector6d error = local(kPose, found.T_reference_camera);
  EXPECT_LT(error.head<3>().norm(), 0.003);
  EXPECT_LT(error.tail<3>().norm(), 0.002);
  EXPECT_GT(found.n_inliers, 130);
  EXPECT_LE(found.n_inliers, 155);
  EXPECT_NEAR(found.mean_chi2, 1.0, 0.25);
}

TEST(PoseRefiner, CovarianceIsThatOfTheError) {
  const CameraModel camera;
  std::mt19937 random(7);
  double normalised = 0.0;
  constexpr int kTrials = 200;
  for (int i = 0; i < kTrials; ++i) {
    const auto matches = made_up_matches(camera, kPose, 60, 0, 1.0, &random);
    const RefinedPose found = refine_pose(camera, matches, kPose);
    const Vector6d error = local(found.T_reference_camera, kPose);
    normalised += error.dot(found.covariance.ldlt().solve(error)) / kTrials;
  }
  EXPECT_NEAR(normalised, 6.0, 1.5);  // the mean of chi square with 6 degrees of freedom
}

TEST(PoseRefiner, TooFewMatchesSaySo) {
  const CameraModel camera;
  EXPECT_EQ(refine_pose(camera, {}, kPose).n_inliers, 0);
  std::mt19937 random(9);
  const RefinedPose two =
      refine_pose(camera, made_up_matches(camera, kPose, 2, 0, 0.0, &random), kPose);
  EXPECT_EQ(two.covariance, Matrix6d(Matrix6d::Identity()));
  EXPECT_TRUE(two.T_reference_camera.matrix().allFinite());
}

TEST(PoseRefiner, CovarianceInBaseAxesFollowsTheMounting) {
  const SE3 T_base_camera = from_xyz_rpy(0.2, 0.1, 0.4, -1.2, 0.3, -1.5);
  const SE3 T_odom_base = from_xyz_rpy(1.0, 2.0, 0.0, 0.0, 0.0, 0.6);
  Vector6d xi;
  xi << 1e-5, 2e-5, -3e-5, 2e-5, -1e-5, 3e-5;
  const SE3 moved_base = retract(T_odom_base * T_base_camera, xi) * T_base_camera.inverse();
  const Vector6d in_base = local(T_odom_base, moved_base);
  const Matrix6d told = in_base_axes(xi * xi.transpose(), T_base_camera);
  EXPECT_LT((told - in_base * in_base.transpose()).norm(), 1e-4 * told.norm());
}

}  // namespace
}  // namespace fusion_slam
