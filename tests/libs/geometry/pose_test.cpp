#include "libs/geometry/pose.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "libs/geometry/orthonormal.hpp"

namespace fusion_slam {
namespace {

SE3 random_pose(std::mt19937& rng) {
  std::uniform_real_distribution<double> u(-3.0, 3.0);
  return from_xyz_rpy(u(rng), u(rng), u(rng), u(rng), u(rng) / 2.0, u(rng));
}

TEST(Pose, RetractUndoesLocal) {
  std::mt19937 rng(1);
  for (int i = 0; i < 200; ++i) {
    const SE3 a = random_pose(rng);
    const SE3 b = random_pose(rng);
    EXPECT_TRUE(retract(a, local(a, b)).isApprox(b, 1e-9));
  }
}

// A map corrected by T_new_old = T_new * T_old^-1 again and again: rounding must not grow.
TEST(Pose, CorrectedAThousandTimesAPoseIsStillOne) {
  std::mt19937 rng(7);
  SE3 old = random_pose(rng);
  for (int i = 0; i < 1000; ++i) {
    const SE3 corrected = orthonormal(retract(old, Vector6d::Constant(1e-3)));
    old = orthonormal(corrected * old.inverse() * old);
    ASSERT_TRUE((old.linear() * old.linear().transpose()).isIdentity(1e-14)) << i;
  }
  const SE3 T = random_pose(rng);
  EXPECT_TRUE(orthonormal(T).isApprox(T, 1e-15));
}

TEST(Pose, LogIsExactNearZeroAndNearPi) {
  for (const double angle : {1e-14, 1e-9, 1e-4, 1.0, 3.0, M_PI - 1e-7}) {
    const Eigen::Vector3d v = angle * Eigen::Vector3d(1, -2, 2).normalized();
    EXPECT_NEAR((log_so3(exp_so3(v)) - v).norm(), 0.0, 1e-8) << angle;
  }
}

TEST(Pose, Se2AgreesWithSe3) {
  std::mt19937 rng(2);
  std::uniform_real_distribution<double> u(-3.0, 3.0);
  for (int i = 0; i < 100; ++i) {
    const SE2 a{u(rng), u(rng), u(rng)};
    const SE2 b{u(rng), u(rng), u(rng)};
    const SE2 ab = to_se2(to_se3(a) * to_se3(b));
    EXPECT_NEAR((a * b).x, ab.x, 1e-12);
    EXPECT_NEAR((a * b).y, ab.y, 1e-12);
    EXPECT_NEAR(wrap_angle((a * b).yaw - ab.yaw), 0.0, 1e-12);
    EXPECT_NEAR((a * a.inverse()).x, 0.0, 1e-12);
  }
}

TEST(Pose, InterpolateMeetsItsEnds) {
  std::mt19937 rng(3);
  const SE3 a = random_pose(rng);
  const SE3 b = random_pose(rng);
  EXPECT_TRUE(interpolate(a, b, 0.0).isApprox(a, 1e-12));
  EXPECT_TRUE(interpolate(a, b, 1.0).isApprox(b, 1e-9));
}

TEST(Pose, WrapKeepsPiPositive) {
  EXPECT_DOUBLE_EQ(wrap_angle(3.0 * M_PI), M_PI);
  EXPECT_DOUBLE_EQ(wrap_angle(-M_PI), M_PI);
  EXPECT_NEAR(wrap_angle(2.0 * M_PI + 0.1), 0.1, 1e-12);
}

TEST(Pose, OpticalAxisLooksForward) {
  EXPECT_EQ(optical_to_body() * Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX());
  EXPECT_EQ(optical_to_body() * Eigen::Vector3d::UnitY(), -Eigen::Vector3d::UnitZ());
}

TEST(Pose, RotationToZ) {
  const Eigen::Vector3d up = Eigen::Vector3d(0.3, -0.2, 0.9).normalized();
  EXPECT_LT((rotation_to_z(up) * up - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR(log_so3(rotation_to_z(up)).norm(), std::acos(up.z()), 1e-9);  // none is smaller
  EXPECT_TRUE(rotation_to_z(Eigen::Vector3d::UnitZ()).isIdentity(1e-12));
}

TEST(Pose, LevellingGivesZRollAndPitchAndNothingElse) {
  std::mt19937 rng(5);
  for (int i = 0; i < 100; ++i) {
    const SE3 T_old_a = random_pose(rng);
    const SE3 wanted = random_pose(rng);
    const SE3 L = levelling(T_old_a, wanted);
    const SE3 T_new_a = L * T_old_a;
    EXPECT_NEAR(T_new_a.translation().z(), wanted.translation().z(), 1e-9);
    EXPECT_LT((T_new_a.linear().row(2) - wanted.linear().row(2)).norm(), 1e-9);  // roll, pitch
    EXPECT_NEAR(log_so3(L.linear()).z(), 0.0, 1e-9);  // its axis is level: no needless yaw
    EXPECT_EQ(L.translation().head<2>().norm(), 0.0);
    EXPECT_TRUE(levelling(T_new_a, wanted).isApprox(SE3::Identity(), 1e-9));  // done is done
  }
}

}  // namespace
}  // namespace fusion_slam
