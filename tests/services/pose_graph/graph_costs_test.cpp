#include "services/pose_graph/graph_costs.hpp"

#include <random>

#include <gtest/gtest.h>

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

// Central differences along the manifold against what the cost says.
void expect_jacobians_match(const ceres::CostFunction& cost, std::vector<PoseBlock> blocks) {
  const int n_residuals = cost.num_residuals();
  std::vector<const double*> pointers;
  for (const PoseBlock& block : blocks) pointers.push_back(block.data());
  std::vector<std::vector<double>> analytic(blocks.size(),
                                            std::vector<double>(n_residuals * 7, 1e9));
  std::vector<double*> jacobians;
  for (auto& J : analytic) jacobians.push_back(J.data());
  std::vector<double> residuals(n_residuals);
  ASSERT_TRUE(cost.Evaluate(pointers.data(), residuals.data(), jacobians.data()));

  const double h = 1e-6;
  const PoseManifold manifold;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const PoseBlock original = blocks[b];
    for (int k = 0; k < 6; ++k) {
      std::vector<double> plus(n_residuals);
      std::vector<double> minus(n_residuals);
      Vector6d delta = Vector6d::Zero();
      delta[k] = h;
      manifold.Plus(original.data(), delta.data(), blocks[b].data());
      cost.Evaluate(pointers.data(), plus.data(), nullptr);
      delta[k] = -h;
      manifold.Plus(original.data(), delta.data(), blocks[b].data());
      cost.Evaluate(pointers.data(), minus.data(), nullptr);
      blocks[b] = original;
      for (int r = 0; r < n_residuals; ++r) {
        const double numeric = (plus[r] - minus[r]) / (2.0 * h);
        EXPECT_NEAR(analytic[b][r * 7 + k], numeric, 1e-5 * (1.0 + std::abs(numeric)))
            << "block " << b << " residual " << r << " direction " << k;
      }
    }
    for (int r = 0; r < n_residuals; ++r) EXPECT_EQ(analytic[b][r * 7 + 6], 0.0);
  }
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

TEST(GraphCosts, ManifoldIsRetractAndItsInverse) {
  std::mt19937 rng(4);
  const PoseManifold manifold;
  for (int i = 0; i < 20; ++i) {
    const PoseBlock x = to_block(random_pose(rng));
    const PoseBlock y = to_block(random_pose(rng));
    Vector6d delta;
    PoseBlock back;
    manifold.Minus(y.data(), x.data(), delta.data());
    manifold.Plus(x.data(), delta.data(), back.data());
    EXPECT_TRUE(from_block(back.data()).isApprox(from_block(y.data()), 1e-9));
  }
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
