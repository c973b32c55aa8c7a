#include "services/lidar_mapper/motion_predictor.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

constexpr std::int64_t kSecond = 1'000'000;

TEST(MotionSource, InterpolatesAndExtrapolatesALittle) {
  MotionSource source;
  const Twist twist{0.5, 0.0, 0.3};
  for (int i = 0; i <= 10; ++i) source.add(i * kSecond / 10, SE2{3, 4, 1} * twist.motion(i * 0.1));
  const auto inside = source.motion(250'000, 830'000, 0.3);
  ASSERT_TRUE(inside);
  EXPECT_NEAR(inside->x, twist.motion(0.58).x, 1e-9);
  EXPECT_NEAR(inside->yaw, 0.58 * 0.3, 1e-9);
  const auto ahead = source.motion(900'000, 1'200'000, 0.3);
  ASSERT_TRUE(ahead);
  EXPECT_NEAR(ahead->yaw, 0.09, 1e-9);
  EXPECT_FALSE(source.motion(900'000, 1'400'000, 0.3));
  EXPECT_FALSE(source.motion(-100'000, 500'000, 0.3));
}

TEST(MotionSource, LateRepeatedAndRestartedStampsDoNoHarm) {
  MotionSource source;
  source.add(10 * kSecond, {0, 0, 0});
  source.add(10 * kSecond, {9, 9, 0});
  source.add(10 * kSecond - 1000, {9, 9, 0});
  source.add(10 * kSecond + 100'000, {0.1, 0, 0});
  EXPECT_NEAR(source.motion(10 * kSecond, 10 * kSecond + 100'000, 0.3)->x, 0.1, 1e-12);
  source.add(kSecond, {5, 5, 0});  // a new recording
  EXPECT_FALSE(source.motion(10 * kSecond, 10 * kSecond + 100'000, 0.3));
}

TEST(MotionSource, AcrossAGapNothingIsSaid) {
  MotionSource source;
  source.add(0, {0, 0, 0});
  source.add(3 * kSecond, {2, 0, 0});
  EXPECT_FALSE(source.motion(kSecond, 2 * kSecond, 0.3));
  source.add(3 * kSecond + 100'000, {2.1, 0, 0});
  EXPECT_FALSE(source.motion(0, 3 * kSecond + 100'000, 0.3)) << "its frame may be another one";
  EXPECT_TRUE(source.motion(3 * kSecond, 3 * kSecond + 100'000, 0.3));
}

TEST(MotionPredictor, OdometryThenVisionThenTheLastVelocity) {
  const LidarMapperConfig config;
  MotionPredictor predictor(config);
  for (int i = 0; i <= 5; ++i) predictor.add_scan_pose(0.2, {0.02 * i, 0.0, 0.0});
  const ScanClock::Interval fifth{0.2, true};
  auto p = predictor.predict(1'000'000, 1'200'000, fifth, 0.05);
  EXPECT_EQ(p.source, PredictionSource::kConstantVelocity);
  EXPECT_NEAR(p.motion.x, 0.02, 1e-9);

  predictor.add_visual(1'000'000, {0, 0, 0});
  predictor.add_visual(1'200'000, {0.05, 0, 0});
  p = predictor.predict(1'000'000, 1'200'000, fifth, 0.05);
  EXPECT_EQ(p.source, PredictionSource::kVisual);
  EXPECT_NEAR(p.motion.x, 0.05, 1e-9);

  predictor.add_odometry(1'000'000, {7, 7, 0});
  predictor.add_odometry(1'200'000, {7.08, 7, 0});
  p = predictor.predict(1'000'000, 1'200'000, fifth, 0.05);
  EXPECT_EQ(p.source, PredictionSource::kOdometry);
  EXPECT_NEAR(p.motion.x, 0.08, 1e-9);

  predictor.visual_lost();
  predictor.add_odometry(1'210'000, {70, 7, 0});  // wheels don't jump 63 m
  p = predictor.predict(1'200'000, 1'210'000, {0.2, true}, 0.05);
  EXPECT_EQ(p.source, PredictionSource::kConstantVelocity);
}

// As in MIT CSAIL: for three scans the wheels seem to stand, then they jump.
TEST(MotionPredictor, OdometryThatContradictsTheLastVelocityIsGivenRoom) {
  const LidarMapperConfig config;
  MotionPredictor predictor(config);
  for (int i = 0; i <= 5; ++i) {
    predictor.add_odometry(i * kSecond / 5, {0.2 * i, 0.0, 0.0});
    predictor.add_scan_pose(0.2, {0.2 * i, 0.0, 0.0});
  }
  predictor.add_odometry(6 * kSecond / 5, {1.2, 0.0, 0.0});
  predictor.add_odometry(7 * kSecond / 5, {1.2, 0.0, 0.0});
  const ScanClock::Interval fifth{0.2, true};
  const auto well = predictor.predict(kSecond, 6 * kSecond / 5, fifth, 0.05);
  const auto stalled = predictor.predict(6 * kSecond / 5, 7 * kSecond / 5, fifth, 0.05);
  EXPECT_EQ(stalled.source, PredictionSource::kOdometry);
  EXPECT_GT(stalled.window_m, 0.2);  // the last velocity lies inside
  EXPECT_GT(stalled.sigma_m, 2.0 * well.sigma_m);
  EXPECT_LT(well.sigma_m, 0.05);
}

// A source is believed as it deserves: not beyond what its starting values allow.
TEST(MotionPredictor, TrustFollowsTheMatches) {
  const LidarMapperConfig config;
  MotionPredictor predictor(config);
  const auto odometry = PredictionSource::kOdometry;
  const Eigen::Vector3d expected(1e-4, 1e-4, 1e-4);
  for (int i = 0; i < 200; ++i) predictor.learn(odometry, {0.03, 0.0, 0.001}, expected);
  EXPECT_NEAR(predictor.trust(odometry).x(), 3.0, 0.01);
  EXPECT_NEAR(predictor.trust(odometry).y(), 0.5, 0.01);
  EXPECT_NEAR(predictor.trust(PredictionSource::kVisual).x(), 1.0, 1e-12);
  for (int i = 0; i < 200; ++i) predictor.learn(odometry, {9, 9, 9}, Eigen::Vector3d::Zero());
  EXPECT_NEAR(predictor.trust(odometry).x(), 3.0, 0.01);  // the match saw nothing
}

TEST(MotionPredictor, TinyIntervalsDoNotMakeHugeVelocities) {
  const LidarMapperConfig config;
  MotionPredictor predictor(config);
  for (int i = 0; i <= 5; ++i) predictor.add_scan_pose(1e-3, {0.1 * i, 0.0, 0.5 * i});
  const auto p = predictor.predict(0, 200'000, {0.2, false}, 0.05);
  EXPECT_LE(std::abs(p.twist.vx_mps), config.max_speed_mps);
  EXPECT_LE(std::abs(p.twist.turn_radps), config.max_turn_radps);
}

}  // namespace
}  // namespace fusion_slam
