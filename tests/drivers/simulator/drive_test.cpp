#include "drivers/simulator/drive.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "drivers/simulator/world.hpp"

namespace fusion_slam {
namespace {

World office() { return load_world(std::string(FS_SOURCE_DIR) + "/config/worlds/office.yaml"); }

TEST(Drive, KeepsItsLimitsAndComesBackWithinAMinute) {
  const World world = office();
  const Drive drive(world.route_m, world.limits, 60.0);
  EXPECT_GT(drive.lap_s(), 40.0);
  EXPECT_LT(drive.lap_s(), 60.0);
  const auto& steps = drive.steps();
  for (std::size_t i = 1; i < steps.size(); ++i) {
    ASSERT_LE(steps[i].speed_m_s, 0.5 + 1e-12);
    ASSERT_LE(std::fabs(steps[i].turn_rad_s), 0.9 + 1e-12);
    const double dt = Drive::kStepS;
    ASSERT_LE(std::fabs(steps[i].speed_m_s - steps[i - 1].speed_m_s), 0.6 * dt + 1e-12);
    ASSERT_LE(std::fabs(steps[i].turn_rad_s - steps[i - 1].turn_rad_s), 2.0 * dt + 1e-12);
  }
}

TEST(Drive, TouchesNothing) {
  const World world = office();
  const Drive drive(world.route_m, world.limits, 120.0);
  for (std::size_t i = 0; i < drive.steps().size(); i += 50) {
    const SE2 at = drive.steps()[i].T_world_base;
    for (const Box& box : world.boxes) {
      const Eigen::Vector3d centre = box.T_world_box.translation();
      if (centre.z() + box.half_m.z() < 0.01 || centre.z() - box.half_m.z() > 0.6) continue;
      const Eigen::Vector3d p = box.T_world_box.inverse() * Eigen::Vector3d(at.x, at.y, centre.z());
      const double dx = std::max(0.0, std::fabs(p.x()) - box.half_m.x());
      const double dy = std::max(0.0, std::fabs(p.y()) - box.half_m.y());
      ASSERT_GT(std::hypot(dx, dy), 0.22)
          << "at " << at.x << ", " << at.y << ": thing at " << centre.x() << ", " << centre.y();
    }
  }
}

TEST(Drive, PosesBetweenStepsAreOnTheArc) {
  const World world = office();
  const Drive drive(world.route_m, world.limits, 5.0);
  const Drive::Step& step = drive.steps()[3000];
  const SE2 end = drive.T_world_base(3.001);
  EXPECT_NEAR(end.x, drive.steps()[3001].T_world_base.x, 1e-9);
  const SE2 middle = drive.T_world_base(3.0005);
  EXPECT_NEAR(middle.yaw, step.T_world_base.yaw + 0.0005 * step.turn_rad_s, 1e-9);
}

TEST(WheelOdometry, WithoutSlipIsTheTruthAndWithSlipDrifts) {
  const World world = office();
  const Drive drive(world.route_m, world.limits, 60.0);
  const auto exact = wheel_odometry(drive, WheelNoise{}, 1, false);
  const SE2 T_world_odom = drive.T_world_base(0.0);
  ASSERT_EQ(exact.size(), drive.steps().size());
  for (std::size_t i = 0; i < exact.size(); i += 100) {
    const SE2 is = T_world_odom * exact[i], truth = drive.steps()[i].T_world_base;
    ASSERT_NEAR(is.x, truth.x, 1e-9);
    ASSERT_NEAR(is.y, truth.y, 1e-9);
    ASSERT_NEAR(wrap_angle(is.yaw - truth.yaw), 0.0, 1e-9);
  }
  const auto noisy = wheel_odometry(drive, WheelNoise{}, 1, true);
  const SE2 end = exact.back().inverse() * noisy.back();
  EXPECT_GT(std::hypot(end.x, end.y), 0.02);
  EXPECT_LT(std::hypot(end.x, end.y), 4.0);
}

}  // namespace
}  // namespace fusion_slam
