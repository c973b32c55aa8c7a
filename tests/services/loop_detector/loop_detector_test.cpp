#include "services/loop_detector/loop_detector.hpp"

#include <gtest/gtest.h>

#include "tests/services/loop_detector/made_up_places.hpp"

namespace fusion_slam {
namespace {

const SE3 kSecondView = from_xyz_rpy(0.3, -0.1, 0.2, 0.1, -0.2, 0.15);

RobotModel carried_camera() {
  RobotModel robot;
  robot.has_camera = true;
  robot.planar = false;
  robot.T_base_camera = from_xyz_rpy(0.2, 0.0, 0.3, -1.5707963, 0.0, -1.5707963);
  return robot;
}

// Place 1 first, then 29 others. The motion between keyframes is unknown, so any loop is possible.
LoopDetector driven(const CameraModel& camera, const LoopDetectorConfig& config = {}) {
  LoopDetector detector(carried_camera(), config);
  detector.set_camera(camera);
  for (int id = 1; id <= 30; ++id)
    EXPECT_TRUE(
        detector.add(keyframe_at(id, see_place(make_place(id), camera, SE3::Identity(), id)))
            .empty());
  return detector;
}

TEST(LoopDetector, KnowsAPlaceAgainAndFromWhere) {
  const CameraModel camera;
  LoopDetector detector = driven(camera);
  const auto found =
      detector.add(keyframe_at(31, see_place(make_place(1), camera, kSecondView, 31)));
  EXPECT_TRUE(found.empty());  // where the graph knows so little, one view is not enough
  const auto decided =
      detector.add(keyframe_at(32, see_place(make_place(1), camera, kSecondView, 32)));
  EXPECT_TRUE(decided.empty());
  const auto at_end = detector.finish();
  ASSERT_EQ(at_end.size(), 2U);
  const LoopCandidate& loop = at_end[0];
  EXPECT_EQ(loop.from.id, 1);
  EXPECT_EQ(loop.to.id, 31);
  EXPECT_FALSE(loop.accepted);
  ASSERT_EQ(loop.stages.size(), 4U);
  EXPECT_EQ(loop.stages[0].stage, "appearance");
  EXPECT_TRUE(loop.stages[0].passed);
  EXPECT_GT(loop.stages[0].score, 0.3);
  EXPECT_EQ(loop.stages[1].stage, "geometry");
  EXPECT_TRUE(loop.stages[1].passed);
  EXPECT_GT(loop.stages[1].score, 100);
  EXPECT_EQ(loop.stages[2].reason, "the robot has no LiDAR");
  EXPECT_NE(loop.stages[3].reason.find("1 of 2 loops"), std::string::npos) << loop.stages[3].reason;
  ASSERT_EQ(loop.measurements.size(), 1U);
  const SE3 T_base_camera = carried_camera().T_base_camera;
  const SE3 expected = T_base_camera * kSecondView * T_base_camera.inverse();
  EXPECT_LT(local(expected, loop.measurements[0].T_from_to).head<3>().norm(), 0.01);
  EXPECT_LT(local(expected, loop.measurements[0].T_from_to).tail<3>().norm(), 0.005);
  EXPECT_GT(loop.measurements[0].same_features.size(), 100U);
}

// Keyframes with edges: the graph knows the way, and two views along it tell the same story.
TEST(LoopDetector, ALoopThatTheGraphExpectsIsAccepted) {
  const CameraModel camera;
  LoopDetector detector(carried_camera());
  detector.set_camera(camera);
  std::vector<LoopCandidate> decided;
  for (int id = 1; id <= 40; ++id) {
    LoopKeyframe keyframe = keyframe_at(
        id, see_place(make_place(id <= 20 ? id : 41 - id), camera, SE3::Identity(), id));
    const int x = id <= 20 ? id : 41 - id;
    keyframe.T_odom_base = from_xyz_rpy(x, 0, 0, 0, 0, 0);
    keyframe.previous_id = id - 1;
    keyframe.T_previous_base = from_xyz_rpy(id <= 20 ? 1 : (id == 21 ? 0 : -1), 0, 0, 0, 0, 0);
    for (auto& c : detector.add(keyframe)) decided.push_back(c);
  }
  ASSERT_FALSE(decided.empty());
  for (const LoopCandidate& c : decided) {
    EXPECT_EQ(c.from.id + c.to.id, 41);
    EXPECT_TRUE(c.accepted) << c.stages.back().reason;
  }
  EXPECT_GT(decided.size(), 5U);
}

// The same looks, but the graph knows that the robot is 30 m from there: posters of one kind.
TEST(LoopDetector, ATwinFarAwayIsRejectedByTheGraph) {
  const CameraModel camera;
  LoopDetector detector(carried_camera());
  detector.set_camera(camera);
  std::vector<LoopCandidate> decided;
  for (int id = 1; id <= 35; ++id) {
    LoopKeyframe keyframe = keyframe_at(
        id, see_place(make_place(id <= 30 ? id : id - 30), camera, SE3::Identity(), id));
    keyframe.T_odom_base = from_xyz_rpy(id, 0, 0, 0, 0, 0);
    keyframe.previous_id = id - 1;
    keyframe.T_previous_base = from_xyz_rpy(1, 0, 0, 0, 0, 0);
    for (auto& c : detector.add(keyframe)) decided.push_back(c);
  }
  EXPECT_EQ(decided.size(), 5U);
  for (const LoopCandidate& c : decided) {
    EXPECT_FALSE(c.accepted);
    EXPECT_TRUE(c.stages[1].passed);
    EXPECT_NE(c.stages[3].reason.find("more than it can be wrong"), std::string::npos)
        << c.stages[3].reason;
  }
}

TEST(LoopDetector, SimilarLooksInAnotherArrangementFailGeometry) {
  const CameraModel camera;
  LoopDetector detector = driven(camera);
  MadeUpPlace shuffled = make_place(1);
  shuffled.points = make_place(77).points;
  const auto found =
      detector.add(keyframe_at(31, see_place(shuffled, camera, SE3::Identity(), 31)));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].stages[0].passed);
  EXPECT_FALSE(found[0].stages[1].passed);
  EXPECT_FALSE(found[0].accepted);
}

TEST(LoopDetector, TheNewestKeyframesAreNoPlaces) {
  const CameraModel camera;
  LoopDetector detector(carried_camera());
  detector.set_camera(camera);
  for (int id = 1; id <= 12; ++id)
    EXPECT_TRUE(
        detector.add(keyframe_at(id, see_place(make_place(1), camera, kSecondView, id))).empty());
  EXPECT_TRUE(detector.finish().empty());
}

TEST(LoopDetector, RepeatedAndEmptyKeyframesDoNoHarm) {
  const CameraModel camera;
  LoopDetector detector = driven(camera);
  EXPECT_TRUE(
      detector.add(keyframe_at(5, see_place(make_place(1), camera, kSecondView, 5))).empty());
  EXPECT_EQ(detector.counts().keyframes, 30);
  EXPECT_TRUE(detector.add(keyframe_at(31, {})).empty());
}

}  // namespace
}  // namespace fusion_slam
