#include "libs/scan_matching/scan_refiner.hpp"

#include <gtest/gtest.h>

#include "libs/scan_matching/overlap.hpp"
#include "tests/libs/scan_matching/drawn_room.hpp"

namespace fusion_slam {
namespace {

TEST(ScanRefiner, FindsTheTruthToAFractionOfACell) {
  const Raster raster = room_raster();
  std::mt19937 rng(4);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (int i = 0; i < 20; ++i) {
    const SE2 truth{0.5 * u(rng), 0.5 * u(rng), 0.3 * u(rng)};
    const Points points = room_points(truth, 300, 0.01, static_cast<std::uint32_t>(i));
    const SE2 start = truth * SE2{0.03 * u(rng), 0.03 * u(rng), 0.01 * u(rng)};
    const RefinedMatch match = refine_match(raster, points, start, {start, 0.1, 0.1});
    // The drawn wall is one cell wide and the cell's centre may be half a cell off the line.
    EXPECT_NEAR(match.T_grid_base.x, truth.x, 0.03);
    EXPECT_NEAR(match.T_grid_base.y, truth.y, 0.03);
    EXPECT_NEAR(match.T_grid_base.yaw, truth.yaw, 0.01);
    EXPECT_LT(std::sqrt(match.covariance(0, 0)), 0.02);
    EXPECT_LT(match.weakest_sigma_m, 0.05);
  }
}

// Two parallel walls say nothing of the position between their ends: whatever the robot's heading,
// the uncertainty lies along the corridor, in base axes, and the prediction stands in that
// direction.
TEST(ScanRefiner, ACorridorIsUncertainAlongItself) {
  Raster raster(0.05, kUnknownCell);
  draw_line(raster, {-20, 1.01}, {20, 1.01}, cell_from_probability(0.9));
  draw_line(raster, {-20, -1.01}, {20, -1.01}, cell_from_probability(0.9));
  for (const double yaw : {0.0, 1.0, M_PI / 2.0}) {
    const SE2 truth{0.2, 0.0, yaw};
    Points points;
    for (int i = -40; i <= 40; ++i)
      for (const double y : {1.025, -1.025})
        points.push_back(truth.inverse() * Eigen::Vector2d(0.05 * i, y));
    const PosePrior prior{{0.2, 0.03, yaw}, 0.2, 0.1};
    const RefinedMatch match = refine_match(raster, points, prior.T_grid_base, prior);
    EXPECT_NEAR(match.T_grid_base.x, 0.2, 1e-3);
    EXPECT_NEAR(match.T_grid_base.y, 0.0, 0.03);
    const Eigen::Vector3d along(std::cos(yaw), -std::sin(yaw), 0.0);
    const Eigen::Vector3d across(std::sin(yaw), std::cos(yaw), 0.0);
    EXPECT_NEAR(std::sqrt(along.dot(match.covariance * along)), 0.2, 0.01);
    EXPECT_LT(std::sqrt(across.dot(match.covariance * across)), 0.02);
    EXPECT_GT(match.weakest_sigma_m, 1.0);
  }
}

TEST(ScanRefiner, WithoutPointsThePriorStands) {
  const RefinedMatch match = refine_match(room_raster(), {}, {1, 2, 0.5}, {{1, 2, 0.5}, 0.2, 0.1});
  EXPECT_NEAR(match.T_grid_base.x, 1.0, 1e-9);
  EXPECT_NEAR(match.covariance(2, 2), 0.01, 1e-9);
}

TEST(Overlap, CountsWhatAgrees) {
  const Raster raster = room_raster();
  const SE2 truth{0.3, 0.2, 0.4};
  const Points points = room_points(truth, 200, 0.01, 9);
  const Overlap good = measure_overlap(raster, points, truth);
  EXPECT_EQ(good.n_points, 200);
  EXPECT_GT(good.agreement(), 0.99);
  EXPECT_LT(measure_overlap(raster, points, truth * SE2{0.7, 0.5, 0.4}).n_matched, 60);
  EXPECT_EQ(measure_overlap(raster, {}, truth).agreement(), 0.0);
}

}  // namespace
}  // namespace fusion_slam
