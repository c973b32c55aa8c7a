#include "services/visual_odometry/motion_model.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TEST(MotionModel, KeepsTheVelocityAtAnyFrameRate) {
  Vector6d step;
  step << 0.01, 0.0, 0.02, 0.0, 0.03, 0.01;
  const SE3 first = from_xyz_rpy(1, 2, 3, 0.1, 0.2, 0.3);
  const SE3 second = retract(first, step);
  MotionModel model;
  model.update(1'000'000, first);
  EXPECT_LT(local(model.predict(1'030'000), first).norm(), 1e-12);
  model.update(1'030'000, second);
  EXPECT_LT(local(model.predict(1'060'000), retract(second, step)).norm(), 1e-9);
  EXPECT_LT(local(model.predict(1'090'000), retract(second, 2.0 * step)).norm(), 1e-9);
}

TEST(MotionModel, StandsStillAfterAGapOrARestart) {
  MotionModel model;
  model.update(1'000'000, SE3::Identity());
  model.update(1'030'000, from_xyz_rpy(0.1, 0, 0, 0, 0, 0));
  const SE3 last = from_xyz_rpy(0.1, 0, 0, 0, 0, 0);
  EXPECT_EQ(model.predict(2'000'000).matrix(), last.matrix());
  EXPECT_EQ(model.predict(1'000'000).matrix(), last.matrix());
  model.restart(SE3::Identity());
  EXPECT_EQ(model.predict(1'050'000).matrix(), SE3::Identity().matrix());
  // What lies between the restart and the next pose is a jump, not a velocity.
  model.update(1'060'000, last);
  EXPECT_EQ(model.predict(1'090'000).matrix(), last.matrix());
}

}  // namespace
}  // namespace fusion_slam
