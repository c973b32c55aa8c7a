#include "libs/scan_matching/surface_refiner.hpp"

#include <gtest/gtest.h>

#include "tests/libs/scan_matching/drawn_room.hpp"

namespace fusion_slam {
namespace {

// The room as a mapper would hold it after a few sweeps at known places.
struct RoomMap {
  SurfaceMap surfaces{0.1};
  Raster raster = room_raster();

  RoomMap() {
    std::uint32_t seed = 100;
    for (const SE2& T : {SE2{0, 0, 0}, SE2{0.3, 0.4, 0.5}, SE2{-0.8, -0.5, 2.0}}) {
      SweepPoints sweep = room_sweep(T, {}, 0.0, 0.005, seed++);
      for (auto& p : sweep.points) p = T * p;
      for (auto& n : sweep.normals) n = Eigen::Rotation2Dd(T.yaw) * n;
      surfaces.add(sweep.points, sweep.normals);
    }
  }
};

const MotionPrior kLoose{{}, Eigen::Vector3d(0.04, 0.04, 0.04).asDiagonal(), {}, {0.5, 0.5, 0.7}};

TEST(SurfaceRefiner, GradientIsTheNumericOne) {
  const RoomMap map;
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (int i = 0; i < 10; ++i) {
    const SE2 truth{0.4 * u(rng), 0.4 * u(rng), 3.0 * u(rng)};
    SweepPoints sweep = room_sweep(truth, {}, 0.18, 0.005, static_cast<std::uint32_t>(i));
    if (i % 2 == 1)  // without normals: all by the occupancy
      sweep.normals.assign(sweep.points.size(), Eigen::Vector2d::Zero());
    const SE2 T = truth * SE2{0.02 * u(rng), 0.02 * u(rng), 0.005 * u(rng)};
    const auto value = [&](const Eigen::Matrix<double, 6, 1>& step) {
      return surface_cost(map.surfaces, map.raster, sweep, T * SE2{step[0], step[1], step[2]},
                          {step[3], step[4], step[5]})
          .value;
    };
    const auto gradient = surface_cost(map.surfaces, map.raster, sweep, T, {}).gradient;
    for (int k = 0; k < 6; ++k) {
      Eigen::Matrix<double, 6, 1> step = Eigen::Matrix<double, 6, 1>::Zero();
      step[k] = 1e-8;
      const double numeric = (value(step) - value(-step)) / 2e-8;
      // Walls between surfaces are seen across only: their slope along is left out on purpose.
      EXPECT_NEAR(gradient[k], numeric, 0.02 * gradient.norm() + 1.0) << i << " " << k;
    }
  }
}

// Ten times finer than a cell: what the occupancy alone can't do.
TEST(SurfaceRefiner, FindsTheTruthToMillimetres) {
  const RoomMap map;
  std::mt19937 rng(4);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (std::uint32_t i = 0; i < 20; ++i) {
    const SE2 truth{0.5 * u(rng), 0.5 * u(rng), 3.0 * u(rng)};
    const SweepPoints sweep = room_sweep(truth, {}, 0.0, 0.005, i);
    MotionPrior prior = kLoose;
    prior.T_grid_base = truth * SE2{0.05 * u(rng), 0.05 * u(rng), 0.02 * u(rng)};
    const SurfaceMatch match =
        refine_on_surfaces(map.surfaces, map.raster, sweep, prior.T_grid_base, prior);
    const SE2 error = truth.inverse() * match.T_grid_base;
    EXPECT_LT(std::hypot(error.x, error.y), 0.005);
    EXPECT_LT(std::abs(error.yaw), 0.002);
    EXPECT_GT(match.n_on_surfaces, 200);
    EXPECT_LT(match.weakest_sigma_m, 0.01);
  }
}

// A sweep of 0.18 s while the robot drives and turns: pose and velocity are found together.
TEST(SurfaceRefiner, FindsTheVelocityInTheDistortion) {
  const RoomMap map;
  for (std::uint32_t i = 0; i < 6; ++i) {
    const SE2 truth{0.1 * i, -0.2, 0.6 * i};
    const Twist twist{0.4, 0.0, i % 2 == 0 ? 0.8 : -0.5};
    const SweepPoints sweep = room_sweep(truth, twist, 0.18, 0.005, i);
    MotionPrior prior = kLoose;
    prior.T_grid_base = truth * SE2{0.03, -0.02, 0.02};
    const SurfaceMatch match =
        refine_on_surfaces(map.surfaces, map.raster, sweep, prior.T_grid_base, prior);
    EXPECT_NEAR(match.twist.turn_radps, twist.turn_radps, 0.05);
    EXPECT_NEAR(match.twist.vx_mps, twist.vx_mps, 0.06);
    const SE2 error = truth.inverse() * match.T_grid_base;
    EXPECT_LT(std::hypot(error.x, error.y), 0.012);
    EXPECT_LT(std::abs(error.yaw), 0.005);
  }
}

TEST(SurfaceRefiner, ACorridorIsUncertainAlongItself) {
  SurfaceMap surfaces(0.1);
  Raster raster(0.05, kUnknownCell);
  for (const double y : {-1.0, 1.0}) {
    draw_line(raster, {-20, y + 0.01}, {20, y + 0.01}, cell_from_probability(0.9));
    Points points, normals;
    for (int i = -600; i <= 600; ++i) {
      points.emplace_back(0.03 * i, y + 0.01);
      normals.emplace_back(0.0, y > 0.0 ? -1.0 : 1.0);
    }
    surfaces.add(points, normals);
  }
  for (const double yaw : {0.0, 1.0, M_PI / 2.0}) {
    const SE2 truth{0.2, 0.0, yaw};
    SweepPoints sweep;
    for (const double y : {-0.99, 1.01})
      for (int i = -50; i <= 50; ++i)
        sweep.points.push_back(truth.inverse() * Eigen::Vector2d(0.2 + 0.05 * i, y));
    sweep.normals = surface_normals(sweep.points, {0, 0});
    MotionPrior prior = kLoose;
    prior.T_grid_base = {0.25, 0.03, yaw};
    const SurfaceMatch match =
        refine_on_surfaces(surfaces, raster, sweep, prior.T_grid_base, prior);
    EXPECT_NEAR(match.T_grid_base.x, 0.25, 0.01);  // nobody knows better than the prediction
    EXPECT_NEAR(match.T_grid_base.y, 0.0, 0.003);
    const Eigen::Vector3d along(std::cos(yaw), -std::sin(yaw), 0.0);
    const Eigen::Vector3d across(std::sin(yaw), std::cos(yaw), 0.0);
    EXPECT_NEAR(std::sqrt(along.dot(match.covariance * along)), 0.2, 0.06);
    EXPECT_LT(std::sqrt(across.dot(match.covariance * across)), 0.01);
    EXPECT_GT(match.weakest_sigma_m, 0.1);
  }
}

// What stood there has gone: its surface is still known, but beams pass through it now.
TEST(SurfaceRefiner, SurfacesInFreeCellsAreNotBelieved) {
  RoomMap map;
  const SE2 truth{0.1, 0.1, 0.2};
  const SweepPoints sweep = room_sweep(truth, {}, 0.0, 0.005, 7);
  MotionPrior prior = kLoose;
  prior.T_grid_base = truth;
  EXPECT_GT(refine_on_surfaces(map.surfaces, map.raster, sweep, truth, prior).n_on_surfaces, 200);
  for (const auto& [a, b] : room_walls()) draw_line(map.raster, a, b, cell_from_probability(0.2));
  EXPECT_LT(refine_on_surfaces(map.surfaces, map.raster, sweep, truth, prior).n_on_surfaces, 100);
}

TEST(SurfaceRefiner, WithoutPointsThePriorStands) {
  MotionPrior prior = kLoose;
  prior.T_grid_base = {1, 2, 0.5};
  const SurfaceMatch match =
      refine_on_surfaces(SurfaceMap(0.1), Raster(0.05, kUnknownCell), {}, prior.T_grid_base, prior);
  EXPECT_NEAR(match.T_grid_base.x, 1.0, 1e-12);
  EXPECT_LT((match.covariance - prior.covariance).norm(), 1e-12);
  EXPECT_TRUE(std::isinf(match.weakest_sigma_m));
}

}  // namespace
}  // namespace fusion_slam
