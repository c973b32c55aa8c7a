// A cost's analytic derivatives by poses against central differences along the manifold.
#pragma once

#include <cmath>
#include <vector>

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include "libs/pose_manifold/pose_manifold.hpp"

namespace fusion_slam {

// `blocks`: one pose for each parameter block of the cost, which has no others.
inline void expect_jacobians_match(const ceres::CostFunction& cost, std::vector<PoseBlock> blocks) {
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
      std::vector<double> ends[2];
      for (const int side : {0, 1}) {
        Vector6d delta = Vector6d::Zero();
        delta[k] = side == 0 ? -h : h;
        ends[side].resize(n_residuals);
        manifold.Plus(original.data(), delta.data(), blocks[b].data());
        cost.Evaluate(pointers.data(), ends[side].data(), nullptr);
      }
      blocks[b] = original;
      for (int r = 0; r < n_residuals; ++r) {
        const double numeric = (ends[1][r] - ends[0][r]) / (2.0 * h);
        EXPECT_NEAR(analytic[b][r * 7 + k], numeric, 1e-5 * (1.0 + std::abs(numeric)))
            << "block " << b << " residual " << r << " direction " << k;
      }
    }
    for (int r = 0; r < n_residuals; ++r) EXPECT_EQ(analytic[b][r * 7 + 6], 0.0);
  }
}

}  // namespace fusion_slam
