#include "services/loop_detector/loop_detector_process.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/loop_candidate_t.hpp"
#include "fusion_slam/status_t.hpp"
#include "libs/bus/transport.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "tests/services/loop_detector/keyframe_message.hpp"
#include "tests/services/loop_detector/made_up_places.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

TEST(LoopDetectorProcess, PublishesCandidatesAndOnlyAcceptedConstraints) {
  for (const bool far : {false, true}) {
    auto transport = std::make_shared<Transport>("memq://");
    Bus sender(test_bus("visual_odometry", Mode::kThroughput), transport);
    Bus detector_bus(test_bus("loop_detector", Mode::kThroughput), transport);
    Bus listener(test_bus("listener", Mode::kThroughput), transport);
    const LoopDetectorProcess process(detector_bus);
    std::vector<loop_candidate_t> candidates;
    std::vector<constraint_t> constraints;
    listener.subscribe<loop_candidate_t>(
        "LOOP_CANDIDATE", Policy::kKeepAll,
        [&](const loop_candidate_t& m) { candidates.push_back(m); });
    listener.subscribe<constraint_t>("CONSTRAINT", Policy::kKeepAll,
                                     [&](const constraint_t& m) { constraints.push_back(m); });
    const CameraModel camera;
    RobotModel robot;
    robot.planar = false;
    // The first keyframes come before the models: they wait. Each stands where the last stood, or a
    // metre on: then the loop is impossible.
    const auto say = [&](int id, int place) {
      LoopKeyframe keyframe =
          keyframe_at(id, see_place(make_place(place), camera, SE3::Identity(), id));
      keyframe.T_odom_base = from_xyz_rpy(far ? id : 0, 0, 0, 0, 0, 0);
      keyframe_t message = message_of(keyframe);
      message.previous_id = id - 1;
      message.T_previous_base = to_message(from_xyz_rpy(far ? 1 : 0, 0, 0, 0, 0, 0), 0);
      to_message(Matrix6d(Matrix6d::Identity() * 1e-6), message.covariance);
      sender.publish("KEYFRAME", message);
    };
    for (int id = 1; id <= 30; ++id) say(id, id);
    sender.publish("CAMERA_MODEL", to_message(camera, 40'000'000));
    sender.publish("ROBOT_MODEL", to_message(robot, 40'000'000));
    say(31, 1);
    for (int i = 0; i < 500 && (candidates.empty() || (!far && constraints.empty())); ++i) {
      detector_bus.handle(5);
      listener.handle(5);
    }
    ASSERT_EQ(candidates.size(), 1U);
    EXPECT_EQ(candidates[0].from_id, 1);
    EXPECT_EQ(candidates[0].to_id, 31);
    EXPECT_EQ(candidates[0].n_stages, 4);
    EXPECT_EQ(candidates[0].accepted != 0, !far);
    ASSERT_EQ(constraints.size(), far ? 0U : 1U);
    if (far) continue;
    EXPECT_EQ(constraints[0].source, "visual loop");
    EXPECT_GT(constraints[0].n_same, 100);
  }
}

TEST(LoopDetectorProcess, ImpossibleKeyframesAreRefusedWithAReason) {
  const CameraModel camera;
  const keyframe_t good =
      message_of(keyframe_at(1, see_place(make_place(1), camera, SE3::Identity(), 1)));
  std::string why;
  EXPECT_TRUE(from_message(good, &why));
  keyframe_t bad = good;
  bad.n_descriptor_bytes = 7;
  EXPECT_FALSE(from_message(bad, &why));
  EXPECT_NE(why.find("descriptor"), std::string::npos);
  bad = good;
  bad.u_px[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(from_message(bad, &why));
  EXPECT_NE(why.find("feature 3"), std::string::npos);
  bad = good;
  bad.octave[0] = -1;
  EXPECT_FALSE(from_message(bad, &why));
  bad = good;
  bad.T_odom_base.quat[0] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(from_message(bad, &why));
}

}  // namespace
}  // namespace fusion_slam
