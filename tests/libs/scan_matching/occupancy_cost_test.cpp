#include "libs/scan_matching/occupancy_cost.hpp"

#include <random>

#include <gtest/gtest.h>

#include "tests/libs/scan_matching/drawn_room.hpp"

namespace fusion_slam {
namespace {

// Central differences of all residuals.
void expect_jacobian(const ceres::CostFunction& cost, const double (&at)[3], double tolerance) {
  const int n = cost.num_residuals();
  std::vector<double> r(static_cast<std::size_t>(n)), plus(r), minus(r);
  std::vector<double> J(static_cast<std::size_t>(3 * n));
  double pose[3] = {at[0], at[1], at[2]};
  const double* parameters[] = {pose};
  double* jacobians[] = {J.data()};
  ASSERT_TRUE(cost.Evaluate(parameters, r.data(), jacobians));
  const double h = 1e-6;
  for (int k = 0; k < 3; ++k) {
    pose[k] = at[k] + h;
    cost.Evaluate(parameters, plus.data(), nullptr);
    pose[k] = at[k] - h;
    cost.Evaluate(parameters, minus.data(), nullptr);
    pose[k] = at[k];
    for (int i = 0; i < n; ++i) {
      const auto u = static_cast<std::size_t>(i);
      EXPECT_NEAR(J[3 * u + static_cast<std::size_t>(k)], (plus[u] - minus[u]) / (2.0 * h),
                  tolerance)
          << "residual " << i << " parameter " << k;
    }
  }
}

TEST(OccupancyCost, JacobianIsTheNumericOne) {
  const Raster raster = room_raster();
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> u(-0.05, 0.05);
  for (int i = 0; i < 20; ++i) {
    const SE2 truth{u(rng) * 10, u(rng) * 10, u(rng) * 40};
    const Points points = room_points(truth, 40, 0.03, static_cast<std::uint32_t>(i));
    const OccupancyCost cost(raster, points, 0.5);
    expect_jacobian(cost, {truth.x + u(rng), truth.y + u(rng), truth.yaw + u(rng)}, 2e-3);
  }
}

TEST(PriorCost, JacobianIsTheNumericOneAndHeadingsWrap) {
  const PriorCost cost({0.3, -0.2, 3.1}, 0.1, 0.05);
  expect_jacobian(cost, {0.25, -0.1, -3.1}, 1e-6);
  double residuals[3];
  const double pose[3] = {0.3, -0.2, -3.1};
  const double* parameters[] = {pose};
  cost.Evaluate(parameters, residuals, nullptr);
  EXPECT_NEAR(residuals[2], (2.0 * M_PI - 6.2) / 0.05, 1e-9);
}

TEST(Interpolation, MeetsTheCellsAtTheirCentres) {
  const Raster raster = room_raster();
  for (int y = raster.min_y() - 2; y < raster.min_y() + raster.height() + 2; y += 3)
    for (int x = raster.min_x() - 2; x < raster.min_x() + raster.width() + 2; x += 3)
      ASSERT_NEAR(interpolate_probability(raster, (x + 0.5) * 0.05, (y + 0.5) * 0.05).value,
                  match_probability()[raster.at(x, y)], 1e-6);
}

}  // namespace
}  // namespace fusion_slam
