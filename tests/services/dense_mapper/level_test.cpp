#include "services/dense_mapper/level.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

// A room in a frame whose z is up: floor at 0, a table at 0.7, two walls, clutter. Seen from 1.4 m.
std::vector<SurfacePoint> room(bool with_floor) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> uniform(0.0, 3.0);
  std::normal_distribution<double> noise(0.0, 0.03);
  std::vector<SurfacePoint> surfaces;
  const auto add = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
    SurfacePoint s;
    s.p_m = (p + Eigen::Vector3d(noise(random), noise(random), noise(random)) / 3).cast<float>();
    s.normal = (n + Eigen::Vector3d(noise(random), noise(random), noise(random)))
                   .normalized()
                   .cast<float>();
    surfaces.push_back(s);
  };
  for (int i = 0; i < 300; ++i) {
    if (with_floor) add({uniform(random), uniform(random), 0.0}, Eigen::Vector3d::UnitZ());
    add({uniform(random), uniform(random), 0.7}, Eigen::Vector3d::UnitZ());
    add({3.0, uniform(random), 0.5 * uniform(random)}, -Eigen::Vector3d::UnitX());
    add({uniform(random), 3.0, 0.5 * uniform(random)}, -Eigen::Vector3d::UnitY());
    const Eigen::Vector3d any(noise(random), noise(random), noise(random));
    add({uniform(random), uniform(random), 0.4 + 0.3 * uniform(random)}, any.normalized());
  }
  return surfaces;
}

void move(const SE3& T, std::vector<SurfacePoint>* surfaces) {
  for (SurfacePoint& s : *surfaces) {
    s.p_m = (T * s.p_m.cast<double>()).cast<float>();
    s.normal = (T.linear() * s.normal.cast<double>()).cast<float>();
  }
}

TEST(Level, FindsUpAndFloorOfATiltedCamera) {
  const SE3 T_map_room = from_xyz_rpy(0.4, 0.2, -1.4, 0.2, 0.45, 1.0);
  auto surfaces = room(true);
  move(T_map_room, &surfaces);
  // The camera looks down by 30 degrees and is rolled by a few: so is the images' up direction.
  const Eigen::Vector3d image_up =
      T_map_room.linear() * Eigen::Vector3d(0.5, 0.1, 0.86).normalized();
  const auto level =
      estimate_level(surfaces, image_up, {T_map_room * Eigen::Vector3d(1.0, 1.0, 1.4)});
  ASSERT_TRUE(level);
  EXPECT_TRUE(level->floor_seen);
  const SE3 T_level_room = level->T_level_map * T_map_room;
  EXPECT_LT(std::acos(T_level_room.linear()(2, 2)), 0.01);  // z is up
  EXPECT_NEAR((T_level_room * Eigen::Vector3d(1.5, 1.5, 0.0)).z(), 0.0, 0.02);
  EXPECT_NEAR((T_level_room * Eigen::Vector3d(1.5, 1.5, 0.7)).z(), 0.7, 0.02);
}

TEST(Level, ATableIsTheFloorOnlyWithoutABetterOne) {
  const auto with = estimate_level(room(true), Eigen::Vector3d::UnitZ(), {{1, 1, 1.4}});
  EXPECT_NEAR(with->T_level_map.translation().z(), 0.0, 0.02);
  const auto without = estimate_level(room(false), Eigen::Vector3d::UnitZ(), {{1, 1, 1.2}});
  ASSERT_TRUE(without);
  EXPECT_FALSE(without->floor_seen);  // the table is too close below the camera to be a floor
  EXPECT_NEAR(without->T_level_map.translation().z(), 0.0, 0.15);  // the walls' lower ends
}

TEST(Level, CovarianceIsTightInHeightAndTiltOfTheLevelFrame) {
  const SE3 T_level_anchor = from_xyz_rpy(0.3, 0.2, 1.4, 0.2, 0.45, 1.0);
  const Matrix6d anchor = level_covariance(T_level_anchor, true);
  EXPECT_TRUE(anchor.isApprox(anchor.transpose(), 1e-9));
  const Eigen::Matrix3d R = T_level_anchor.linear();
  const Eigen::Matrix3d t = R * anchor.topLeftCorner<3, 3>() * R.transpose();
  const Eigen::Matrix3d r = R * anchor.bottomRightCorner<3, 3>() * R.transpose();
  EXPECT_NEAR(std::sqrt(t(2, 2)), 0.02, 1e-6);
  EXPECT_NEAR(std::sqrt(r(0, 0)), 0.01, 1e-6);
  EXPECT_NEAR(std::sqrt(r(1, 1)), 0.01, 1e-6);
  EXPECT_GT(t(0, 0), 1e5);
  EXPECT_GT(t(1, 1), 1e5);
  EXPECT_GT(r(2, 2), 1e5);
  EXPECT_GT(level_covariance(T_level_anchor, false).trace(), anchor.trace());
}

TEST(Level, SmallErrorsAreNotWorthMovingTheMap) {
  EXPECT_FALSE(worth_levelling(from_xyz_rpy(0, 0, 0.02, 0.002, -0.003, 0), 0.05));
  EXPECT_TRUE(worth_levelling(from_xyz_rpy(0, 0, 0.03, 0, 0, 0), 0.05));
  EXPECT_TRUE(worth_levelling(from_xyz_rpy(0, 0, 0, 0.006, 0, 0), 0.05));
}

TEST(Level, TooLittleDataGivesNothing) {
  EXPECT_FALSE(estimate_level({}, Eigen::Vector3d::UnitZ(), {{0, 0, 1}}));
  EXPECT_FALSE(estimate_level(room(true), Eigen::Vector3d::Zero(), {{0, 0, 1}}));
}

}  // namespace
}  // namespace fusion_slam
