#include "services/loop_detector/loop_detector_process.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/loop_candidate_t.hpp"
#include "fusion_slam/status_t.hpp"
#include "libs/bus/transport.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "tests/services/loop_detector/made_up_places.hpp"

namespace fusion_slam {
namespace {

BusOptions named(const std::string& process) {
  BusOptions options;
  options.process = process;
  options.mode = Mode::kThroughput;
  options.merge_wait_us = 0;
  return options;
}

keyframe_t message_of(const LoopKeyframe& keyframe) {
  keyframe_t m{};
  m.utime = keyframe.utime_us;
  m.id = keyframe.id;
  m.T_odom_base = to_message(keyframe.T_odom_base, keyframe.utime_us);
  m.T_previous_base = m.T_odom_base;
  m.n = static_cast<std::int32_t>(keyframe.features.size());
  m.n_descriptor_bytes = m.n * 32;
  m.descriptors.resize(m.n_descriptor_bytes);
  for (int i = 0; i < m.n; ++i) {
    const Feature& f = keyframe.features.features[i];
    m.u_px.push_back(f.u_px);
    m.v_px.push_back(f.v_px);
    m.depth_m.push_back(f.depth_m);
    m.angle_rad.push_back(f.angle_rad);
    m.octave.push_back(f.octave);
    m.depth_sigma_m.push_back(f.depth_sigma_m);
    m.landmark_id.push_back(0);
    descriptor_to_bytes(keyframe.features.descriptors[i], m.descriptors.data() + 32 * i);
  }
  return m;
}

TEST(LoopDetectorProcess, PublishesCandidatesAndOnlyAcceptedConstraints) {
  for (const bool accept : {false, true}) {
    auto transport = std::make_shared<Transport>("memq://");
    Bus sender(named("visual_odometry"), transport);
    Bus detector_bus(named("loop_detector"), transport);
    Bus listener(named("listener"), transport);
    LoopDetectorConfig config;
    config.accept_without_lidar = accept;
    const LoopDetectorProcess process(detector_bus, config);
    std::vector<loop_candidate_t> candidates;
    std::vector<constraint_t> constraints;
    listener.subscribe<loop_candidate_t>(
        "LOOP_CANDIDATE", Policy::kKeepAll,
        [&](const loop_candidate_t& m) { candidates.push_back(m); });
    listener.subscribe<constraint_t>("CONSTRAINT", Policy::kKeepAll,
                                     [&](const constraint_t& m) { constraints.push_back(m); });
    const CameraModel camera;
    // The first keyframes come before the models: they wait.
    for (int id = 1; id <= 30; ++id)
      sender.publish("KEYFRAME", message_of(keyframe_at(
                                     id, see_place(make_place(id), camera, SE3::Identity(), id))));
    sender.publish("CAMERA_MODEL", to_message(camera, 40'000'000));
    sender.publish("ROBOT_MODEL", to_message(RobotModel(), 40'000'000));
    sender.publish("KEYFRAME", message_of(keyframe_at(
                                   50, see_place(make_place(1), camera, SE3::Identity(), 50))));
    for (int i = 0; i < 500 && (candidates.empty() || (accept && constraints.empty())); ++i) {
      detector_bus.handle(5);
      listener.handle(5);
    }
    ASSERT_EQ(candidates.size(), 1U);
    EXPECT_EQ(candidates[0].from_id, 1);
    EXPECT_EQ(candidates[0].to_id, 50);
    EXPECT_EQ(candidates[0].n_stages, 4);
    EXPECT_EQ(candidates[0].accepted != 0, accept);
    EXPECT_EQ(constraints.size(), accept ? 1U : 0U);
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
