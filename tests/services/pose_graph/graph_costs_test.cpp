#include "services/pose_graph/graph_costs.hpp"

#include <random>

#include <gtest/gtest.h>

#include "tests/support/numeric_jacobians.hpp"

namespace fusion_slam {
namespace {

SE3 random_pose(std::mt19937& rng, double rotation = 1.5) {
  std::uniform_real_distribution<double> t(-3.0, 3.0);
  std::uniform_real_distribution<double> r(-rotation, rotation);
  return from_xyz_rpy(t(rng), t(rng), t(rng), r(rng), r(rng), r(rng));
}

Matrix6d random_covariance(std::mt19937& rng) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  Matrix6d A;
  for (int i = 0; i < 36; ++i) A(i / 6, i % 6) = u(rng);
  return A * A.transpose() + 0.1 * Matrix6d::Identity();
}

TEST(GraphCosts, RelativePoseJacobiansAgreeWithNumericOnes) {
  std::mt19937 rng(1);
  for (int i = 0; i < 40; ++i) {
    const SE3 from = random_pose(rng);
    const SE3 to = random_pose(rng);
    const SE3 measured = i % 2 == 0 ? random_pose(rng) : SE3(from.inverse() * to);
    const RelativePoseCost cost(measured, sqrt_information(random_covariance(rng)));
    expect_jacobians_match(cost, {to_block(from), to_block(to)});
  }
}

TEST(GraphCosts, PlanarJacobiansAgreeWithNumericOnes) {
  std::mt19937 rng(2);
  for (int i = 0; i < 20; ++i)
    expect_jacobians_match(PlanarCost(0.02, 0.01), {to_block(random_pose(rng))});
}

TEST(GraphCosts, ResidualIsTheWhitenedLocalError) {
  std::mt19937 rng(3);
  const SE3 from = random_pose(rng);
  const SE3 measured = random_pose(rng);
  Vector6d xi;
  xi << 0.1, -0.2, 0.3, 0.05, -0.04, 0.02;
  const Matrix6d covariance = random_covariance(rng);
  const PoseBlock a = to_block(from);
  const PoseBlock b = to_block(from * retract(measured, xi));
  const double* parameters[] = {a.data(), b.data()};
  Vector6d residual;
  const RelativePoseCost cost(measured, sqrt_information(covariance));
  ASSERT_TRUE(cost.Evaluate(parameters, residual.data(), nullptr));
  EXPECT_NEAR(residual.squaredNorm(), xi.dot(covariance.inverse() * xi), 1e-9);
}

TEST(GraphCosts, GraduatedLossDerivativesAgreeWithNumericOnes) {
  for (const double mu : {1.0, 7.0, 1000.0}) {
    const GraduatedLoss loss(16.8, mu);
    for (const double s : {0.1, 5.0, 40.0, 3000.0}) {
      double rho[3];
      double plus[3];
      double minus[3];
      const double h = 1e-4 * s;
      loss.Evaluate(s, rho);
      loss.Evaluate(s + h, plus);
      loss.Evaluate(s - h, minus);
      EXPECT_NEAR(rho[1], (plus[0] - minus[0]) / (2 * h), 1e-6);
      EXPECT_NEAR(rho[2], (plus[1] - minus[1]) / (2 * h), 1e-6);
      EXPECT_LE(rho[0], 16.8 * mu);
    }
  }
}

TEST(GraphCosts, ACovarianceThatIsNoneCountsAsWide) {
  EXPECT_TRUE(sqrt_information(Matrix6d::Zero()).isApprox(Matrix6d::Identity()));
  EXPECT_TRUE(sqrt_information(-Matrix6d::Identity()).isApprox(Matrix6d::Identity()));
  EXPECT_TRUE(sqrt_information(Matrix6d::Constant(NAN)).isApprox(Matrix6d::Identity()));
}

}  // namespace
}  // namespace fusion_slam
