// What must hold over time: flat memory while standing, the same result at any speed of the mapping
// thread, segments that find each other again.
#include <chrono>
#include <map>
#include <thread>

#include <gtest/gtest.h>

#include "services/visual_odometry/visual_odometry.hpp"
#include "tests/services/visual_odometry/rendered_wall.hpp"
#include "tests/services/visual_odometry/small_camera.hpp"

namespace fusion_slam {
namespace {

TEST(LongRun, StandingAddsNothing) {
  const CameraModel camera = small_camera();
  const RenderedWall wall;
  VisualOdometry odometry(camera, robot_with(SE3::Identity()), small_config());
  std::int64_t n = 0;
  const auto show = [&](RgbdFrame frame) {
    frame.utime_us = ++n * kFrame_us;
    return odometry.track(frame);
  };
  for (int step = 0; step < 12; ++step) show(wall.see(camera, walk(step), 0));
  const RgbdFrame view = wall.see(camera, walk(12), 0);
  for (int i = 0; i < 10; ++i) show(view);
  const std::size_t n_keyframes = odometry.map().keyframes().size();
  const std::size_t n_landmarks = odometry.map().landmarks().size();
  for (int i = 0; i < 1000; ++i) {
    const TrackingResult result = show(view);
    ASSERT_EQ(result.state, TrackingState::kOk);
    ASSERT_FALSE(result.keyframe);
  }
  EXPECT_EQ(odometry.map().keyframes().size(), n_keyframes);
  EXPECT_EQ(odometry.map().landmarks().size(), n_landmarks);
}

TEST(LongRun, TheSameAtAnySpeedOfTheMappingThread) {
  const CameraModel camera = small_camera();
  const RenderedWall wall;
  std::vector<SE3> poses[2];
  std::vector<std::int64_t> landmarks[2];
  int mappings = 0;
  for (const int run : {0, 1}) {
    VisualOdometry odometry(camera, robot_with(SE3::Identity()), small_config());
    for (int step = 0; step < 40; ++step) {
      const TrackingResult result =
          odometry.track(wall.see(camera, walk(step), (step + 1) * kFrame_us));
      poses[run].push_back(result.T_odom_base);
      if (!result.keyframe) continue;
      const auto& of = result.keyframe->landmark_of_feature;
      landmarks[run].insert(landmarks[run].end(), of.begin(), of.end());
      if (run == 1) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    mappings = odometry.counts().mappings;
  }
  EXPECT_GE(mappings, 3);
  EXPECT_EQ(landmarks[0], landmarks[1]);
  for (std::size_t i = 0; i < poses[0].size(); ++i)
    EXPECT_EQ(poses[0][i].matrix(), poses[1][i].matrix()) << i;
}

// Between two points where results are taken up, tracking goes on with the map as it was, however
// long the thread takes: the map does not change below it, and a caller who gives the thread time
// never waits.
TEST(LongRun, TrackingGoesOnWithTheMapAsItWasWhileTheThreadWorks) {
  const CameraModel camera = small_camera();
  const RenderedWall wall;
  const VisualOdometryConfig config = small_config();
  VisualOdometry odometry(camera, robot_with(SE3::Identity()), config);
  SE3 T_keyframe = SE3::Identity();
  std::size_t n_landmarks = 0;
  int since = 100;  // frames since the last keyframe
  int held = 0;
  for (int step = 0; step < 40; ++step) {
    const int mappings = odometry.counts().mappings;
    const TrackingResult result =
        odometry.track(wall.see(camera, walk(step), (step + 1) * kFrame_us));
    since = result.keyframe ? 0 : since + 1;
    const MapKeyframe& newest = odometry.map().keyframes().rbegin()->second;
    if (since > 0 && since < config.mapping_frames) {
      EXPECT_EQ(odometry.counts().mappings, mappings) << step;
      EXPECT_EQ(newest.T_odom_camera.matrix(), T_keyframe.matrix()) << step;
      EXPECT_EQ(odometry.map().landmarks().size(), n_landmarks) << step;
      ++held;
    }
    if (since == config.mapping_frames) {
      EXPECT_EQ(odometry.counts().mappings, mappings + 1) << step;
    }
    T_keyframe = newest.T_odom_camera;
    n_landmarks = odometry.map().landmarks().size();
  }
  EXPECT_GE(held, 10);
  EXPECT_LE(odometry.counts().mapping_waits, odometry.counts().mappings);
}

TEST(LongRun, SegmentsJoinWhenAKnownPlaceComesIntoSight) {
  CameraModel camera = small_camera();
  camera.width_px *= 2;
  camera.height_px *= 2;
  camera.fx_px = camera.fy_px *= 2;
  camera.cx_px *= 2;
  camera.cy_px *= 2;
  const RenderedWall known(1);
  const RenderedWall unknown(99);
  VisualOdometry odometry(camera, robot_with(SE3::Identity()));
  std::int64_t n = 0;
  const auto show = [&](const RenderedWall& wall, int step) {
    return odometry.track(wall.see(camera, walk(step), ++n * kFrame_us));
  };
  for (int step = 0; step < 30; ++step) show(known, step);
  show(known, 30);  // what local mapping gave is taken up
  TrackingResult result;
  for (int i = 0; i < 20 && !result.keyframe; ++i) result = show(unknown, 30);
  const VisualMap before = odometry.map();
  ASSERT_TRUE(result.keyframe);
  EXPECT_EQ(result.keyframe->previous_id, 0);  // a new segment
  result = show(known, 20);                    // lost again, but this place is known
  EXPECT_EQ(result.state, TrackingState::kOk) << result.reason;
  ASSERT_TRUE(result.keyframe);
  EXPECT_GT(result.keyframe->previous_id, 0);
  EXPECT_EQ(odometry.map().keyframe(result.keyframe->previous_id)->segment, 1);
  EXPECT_EQ(odometry.counts().relocalisations, 1);
  EXPECT_LT(local(walk(0).inverse() * walk(20), result.T_odom_base).norm(), 0.03);
  // Nothing earlier is lost, and it stays so: each keyframe of both segments is where it was.
  for (int step = 21; step < 27; ++step) EXPECT_EQ(show(known, step).state, TrackingState::kOk);
  for (const auto& [id, keyframe] : before.keyframes()) {
    const MapKeyframe* now = odometry.map().keyframe(id);
    ASSERT_NE(now, nullptr) << id;
    EXPECT_EQ(now->segment, keyframe.segment) << id;
    EXPECT_LT(local(keyframe.T_odom_camera, now->T_odom_camera).norm(), 0.01) << id;
  }
}

// The camera goes somewhere else unseen, a second segment begins there, and it walks back.
TEST(LongRun, ASecondSegmentJoinsTheOldMapLaterWithoutAJump) {
  CameraModel camera = small_camera();
  camera.width_px *= 2;
  camera.height_px *= 2;
  camera.fx_px = camera.fy_px *= 2;
  camera.cx_px *= 2;
  camera.cy_px *= 2;
  const RenderedWall wall;
  VisualOdometry odometry(camera, robot_with(SE3::Identity()));
  const auto at = [](double x_m) { return from_xyz_rpy(x_m, 0.0, -1.6, 0.0, 0.0, 0.0); };
  std::int64_t n = 0;
  const auto show = [&](double x_m) {
    return odometry.track(wall.see(camera, at(x_m), ++n * kFrame_us));
  };
  for (int i = 0; i < 15; ++i) show(-2.4 + 0.03 * i);
  TrackingResult result;
  for (int i = 0; i < 30 && !(result.keyframe && result.keyframe->previous_id == 0); ++i)
    result = show(1.0);
  ASSERT_TRUE(result.keyframe);
  double x_m = 1.0;
  SE3 T_before = result.T_odom_base;
  for (int i = 0; i < 120 && odometry.counts().joins == 0; ++i) {
    result = show(x_m -= 0.03);
    ASSERT_NE(result.state, TrackingState::kLost) << x_m << " " << result.reason;
    EXPECT_NEAR((T_before.inverse() * result.T_odom_base).translation().x(), -0.03, 0.02);
    T_before = result.T_odom_base;
  }
  ASSERT_EQ(odometry.counts().joins, 1);
  // One map now: the first keyframe is where it is from here.
  const VisualMap& map = odometry.map();
  for (const auto& [id, keyframe] : map.keyframes())
    EXPECT_EQ(keyframe.segment, map.keyframes().rbegin()->second.segment) << id;
  const SE3 T_first_now = map.keyframe(1)->T_odom_camera.inverse() * result.T_odom_base;
  EXPECT_LT(local(at(-2.4).inverse() * at(x_m), T_first_now).norm(), 0.05);
}

// A closure bends what is old; the robot, in odom, doesn't notice.
TEST(LongRun, ARevisionOfTheGraphMovesOldKeyframesAndNotThePose) {
  const CameraModel camera = small_camera();
  const RenderedWall wall;
  VisualOdometryConfig config = small_config();
  config.redundant_share = 2.0;  // no culling: the old keyframes are still there
  VisualOdometry odometry(camera, robot_with(SE3::Identity()), config);
  std::map<std::int64_t, SE3> T_odom_base;
  TrackingResult result;
  int step = 0;
  for (; step < 200 && T_odom_base.size() < 16; ++step) {
    result = odometry.track(wall.see(camera, walk(step), (step + 1) * kFrame_us));
    if (result.keyframe) T_odom_base[result.keyframe->id] = result.keyframe->T_odom_base;
  }
  ASSERT_EQ(T_odom_base.size(), 16U);
  const SE3 T_map_odom = from_xyz_rpy(2.0, 1.0, 0.0, 0.0, 0.0, 0.5);
  const auto say = [&](const SE3& bend) {
    for (const auto& [id, T] : T_odom_base)
      odometry.add_graph_node(id, T_map_odom * (id <= 3 ? bend : SE3::Identity()) * T);
  };
  say(SE3::Identity());
  std::int64_t n = step;
  const auto show = [&](int from, int to) {
    const SE3 T_before = result.T_odom_base;
    result = odometry.track(wall.see(camera, walk(to), (++n + 1) * kFrame_us));
    EXPECT_EQ(result.state, TrackingState::kOk) << to << " " << result.reason;
    const SE3 T_truth = walk(from).inverse() * walk(to);
    const Vector6d off = local(T_truth, T_before.inverse() * result.T_odom_base);
    EXPECT_LT(off.head<3>().norm(), 0.01) << to;
    EXPECT_LT(off.tail<3>().norm(), 0.01) << to;
  };
  // Standing: no keyframe comes, the thread's result is taken up, then the news.
  const auto stand = [&] {
    for (int i = 0; i < 8; ++i) show(step - 1, step - 1);
  };
  stand();
  EXPECT_EQ(odometry.counts().revised_keyframes, 0);
  say(from_xyz_rpy(0.3, 0.2, 0.1, 0.0, 0.0, 0.1));
  stand();
  for (int i = 0; i < 5; ++i, ++step) show(step - 1, step);
  EXPECT_GT(odometry.counts().revised_keyframes, 0);
}

}  // namespace
}  // namespace fusion_slam
