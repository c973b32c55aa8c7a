#include "libs/pose_manifold/pose_manifold.hpp"

#include <random>

#include <gtest/gtest.h>

#include "tests/support/numeric_jacobians.hpp"

namespace fusion_slam {
namespace {

SE3 random_pose(std::mt19937* random) {
  std::uniform_real_distribution<double> t(-3.0, 3.0);
  std::uniform_real_distribution<double> r(-1.5, 1.5);
  return from_xyz_rpy(t(*random), t(*random), t(*random), r(*random), r(*random), r(*random));
}

TEST(PoseManifold, BlocksHoldPositionThenQuaternionWithWLast) {
  const PoseBlock block = to_block(from_xyz_rpy(1.0, 2.0, 3.0, 0.0, 0.0, M_PI / 2.0));
  const double expected[] = {1.0, 2.0, 3.0, 0.0, 0.0, std::sqrt(0.5), std::sqrt(0.5)};
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(block[i], expected[i], 1e-12);
}

TEST(PoseManifold, PlusIsRetractAndMinusItsInverse) {
  std::mt19937 random(4);
  const PoseManifold manifold;
  for (int i = 0; i < 20; ++i) {
    const SE3 T = random_pose(&random);
    const PoseBlock x = to_block(T);
    const PoseBlock y = to_block(random_pose(&random));
    Vector6d delta;
    PoseBlock back;
    manifold.Minus(y.data(), x.data(), delta.data());
    manifold.Plus(x.data(), delta.data(), back.data());
    EXPECT_TRUE(from_block(back.data()).isApprox(from_block(y.data()), 1e-9));
    EXPECT_TRUE(from_block(back.data()).isApprox(retract(T, delta), 1e-9));
  }
}

// residual = local(target, T); its derivative by the increment at T = target is the identity.
class ToTarget final : public ceres::CostFunction {
 public:
  explicit ToTarget(const SE3& target) : target_(target) {
    set_num_residuals(6);
    mutable_parameter_block_sizes()->push_back(7);
  }
  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    Eigen::Map<Vector6d> out(residuals);
    out = local(target_, from_block(parameters[0]));
    if (jacobians != nullptr) to_block_jacobian<6>(Matrix6d::Identity(), jacobians[0]);
    return true;
  }

 private:
  SE3 target_;
};

TEST(PoseManifold, DerivativesByTheIncrementStandInTheFirstSixColumns) {
  std::mt19937 random(5);
  const SE3 T = random_pose(&random);
  expect_jacobians_match(ToTarget(T), {to_block(T)});
  const PoseManifold manifold;
  Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> minus;
  const PoseBlock x = to_block(T);
  manifold.PlusJacobian(x.data(), plus.data());
  manifold.MinusJacobian(x.data(), minus.data());
  EXPECT_EQ(Matrix6d(minus * plus), Matrix6d(Matrix6d::Identity()));
}

}  // namespace
}  // namespace fusion_slam
