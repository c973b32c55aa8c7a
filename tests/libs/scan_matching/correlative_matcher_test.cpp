#include "libs/scan_matching/correlative_matcher.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/libs/scan_matching/drawn_room.hpp"
#include "tests/libs/scan_matching/exhaustive_match.hpp"

namespace fusion_slam {
namespace {

TEST(CorrelativeMatcher, FindsWhatBruteForceFinds) {
  const Raster raster = room_raster(0.1);
  const SearchPyramid pyramid(raster);
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (int i = 0; i < 12; ++i) {
    const SE2 truth{u(rng), 0.5 * u(rng), 3.0 * u(rng)};
    const Points points = room_points(truth, 60, 0.03, static_cast<std::uint32_t>(i));
    const SE2 predicted = truth * SE2{0.4 * u(rng), 0.4 * u(rng), 0.2 * u(rng)};
    SearchWindow window;
    window.linear_m = i % 3 == 0 ? 2.0 : 0.3 + 0.1 * i;
    window.angular_rad = 0.25;
    const auto match = match_correlative(pyramid, points, predicted, window, 0.0);
    ASSERT_TRUE(match);
    EXPECT_NEAR(match->score, best_score_by_force(raster, points, predicted, window), 1e-9);
  }
}

TEST(CorrelativeMatcher, LandsWithinACellOfTheTruth) {
  const Raster raster = room_raster();
  const SearchPyramid pyramid(raster);
  const SE2 truth{0.63, -0.31, 0.9};
  const Points points = room_points(truth, 150, 0.01, 3);
  for (const SE2& offset : {SE2{0.15, -0.1, 0.2}, SE2{-0.9, 0.8, -0.6}}) {
    SearchWindow window;
    window.linear_m = 1.5;
    window.angular_rad = 1.0;
    const auto match = match_correlative(pyramid, points, truth * offset, window, 0.3);
    ASSERT_TRUE(match);
    EXPECT_NEAR(match->T_grid_base.x, truth.x, 0.06);
    EXPECT_NEAR(match->T_grid_base.y, truth.y, 0.06);
    EXPECT_NEAR(wrap_angle(match->T_grid_base.yaw - truth.yaw), 0.0, 0.03);
  }
}

TEST(CorrelativeMatcher, SaysNothingBelowTheScoreAskedForOrWithoutPoints) {
  const SearchPyramid pyramid(room_raster());
  const Points far = {{50, 50}, {51, 50}, {52, 51}};
  EXPECT_FALSE(match_correlative(pyramid, far, {}, {}, 0.5));
  EXPECT_FALSE(match_correlative(pyramid, {}, {}, {}, 0.0));
  const SearchPyramid nothing((Raster(0.05, kUnknownCell)));
  EXPECT_FALSE(match_correlative(nothing, far, {}, {}, 0.2));
}

TEST(CorrelativeMatcher, AmongEqualsTheOneNearThePredictionWins) {
  Raster corridor(0.05, kUnknownCell);
  draw_line(corridor, {-20, 1}, {20, 1}, cell_from_probability(0.9));
  draw_line(corridor, {-20, -1}, {20, -1}, cell_from_probability(0.9));
  Points points;
  for (int i = -30; i <= 30; ++i) points.insert(points.end(), {{0.1 * i, 1.01}, {0.1 * i, -0.99}});
  const auto match =
      match_correlative(SearchPyramid(corridor), points, {2.0, 0.1, 0.0}, {0.5, 0.3, 0.05}, 0.0);
  ASSERT_TRUE(match);
  EXPECT_NEAR(match->T_grid_base.x, 2.0, 1e-9);
  EXPECT_NEAR(match->T_grid_base.y, 0.0, 0.051);
}

// 95 of 100 poses drawn from a covariance lie in the window of two sigmas, whatever its axes.
TEST(SearchWindow, HoldsWhatTheCovarianceAllows) {
  std::mt19937 rng(6);
  std::normal_distribution<double> normal;
  for (const double yaw : {0.0, 0.7, 2.0}) {
    const Eigen::Vector3d sigma(0.5, 0.05, 0.1);  // long ahead of the robot: a corridor
    const Eigen::Matrix3d base = sigma.array().square().matrix().asDiagonal();
    const SearchWindow window =
        window_from_covariance(grid_axes(base, yaw), 2.0, {0.0, 0.0, 0.0}, {10.0, 10.0, 0.0});
    EXPECT_NEAR(window.linear_m, 1.0, 1e-9);
    EXPECT_NEAR(window.angular_rad, 0.2, 1e-9);
    int inside = 0;
    for (int i = 0; i < 2000; ++i) {
      const SE2 truth = SE2{3, 4, yaw} * SE2{sigma.x() * normal(rng), sigma.y() * normal(rng), 0.0};
      inside +=
          std::abs(truth.x - 3) <= window.linear_m && std::abs(truth.y - 4) <= window.linear_m;
    }
    EXPECT_GT(inside, 1860);
  }
}

TEST(SearchWindow, StaysWithinItsLimitsWhateverTheCovariance) {
  const SearchWindow least{0.1, 0.05, 0.0}, most{4.0, 1.0, 0.0};
  const auto sized = [&](double variance) {
    return window_from_covariance(Eigen::Matrix3d::Identity() * variance, 3.0, least, most);
  };
  EXPECT_EQ(sized(0.0).linear_m, 0.1);
  EXPECT_EQ(sized(0.0).angular_rad, 0.05);
  for (const double nothing : {1e9, -1.0, std::nan("")}) {
    EXPECT_EQ(sized(nothing).linear_m, 4.0);
    EXPECT_EQ(sized(nothing).angular_rad, 1.0);
  }
}

}  // namespace
}  // namespace fusion_slam
