// Tracking that never waits for local mapping: keyframes come while its thread is at work.
#include <algorithm>

#include <gtest/gtest.h>

#include "services/visual_odometry/landmark_creation.hpp"
#include "services/visual_odometry/local_mapping.hpp"
#include "services/visual_odometry/visual_odometry.hpp"
#include "tests/services/visual_odometry/made_up_map.hpp"
#include "tests/services/visual_odometry/rendered_wall.hpp"
#include "tests/services/visual_odometry/small_camera.hpp"

namespace fusion_slam {
namespace {

// The made-up map without its last keyframe, which comes later and sees what it saw.
struct OneToCome {
  MadeUpMap m = make_map(7, 120, 1.0, true);
  MapKeyframe last = *m.map.keyframe(7);
  std::vector<SeenLandmark> seen;

  OneToCome() {
    for (std::size_t i = 0; i < last.landmark_of_feature.size(); ++i)
      if (last.landmark_of_feature[i] % 3 == 0)  // the others will be its own
        seen.push_back({last.landmark_of_feature[i], static_cast<int>(i)});
    last.previous = 6;
    m.map.erase_keyframe(7);
  }
  void come() { insert_keyframe(last, m.camera, seen, m.scales, 0.6, &m.map); }
};

TEST(LiveMapping, AKeyframeThatCameMeanwhileGoesAlongWithWhatItSees) {
  OneToCome o;
  VisualMap& map = o.m.map;
  const std::int64_t id_in_part = 1 + map.landmarks().rbegin()->first;
  const VisualMap before = map.copy_part({4, 5, 6}, {4, 5, 6});
  VisualMap part = before;
  o.come();
  const VisualMap whole = map;
  ASSERT_NE(whole.landmark(id_in_part), nullptr);  // given here too: the first that 7 made

  const auto& of_six = part.keyframe(6)->landmark_of_feature;
  const auto free = std::find(of_six.begin(), of_six.end(), 9) - of_six.begin();
  ASSERT_LT(free, static_cast<std::ptrdiff_t>(of_six.size()));
  part.erase_landmark(3);  // both of them seen by 7
  part.merge(6, 12);
  part.unlink(9, 6);  // and another one made of that feature
  ASSERT_EQ(part.add_landmark(*part.landmark(15)), id_in_part);
  part.landmark(id_in_part)->observations.clear();
  ASSERT_TRUE(part.link(id_in_part, 6, static_cast<int>(free)));
  const SE3 T = from_xyz_rpy(0.02, 0.01, -0.03, 0.01, 0.02, 0.03);
  part.keyframe(6)->T_odom_camera = T * part.keyframe(6)->T_odom_camera;
  map.put_back(before, part);

  EXPECT_TRUE(consistent(map));
  EXPECT_EQ(map.landmark(3), nullptr);
  EXPECT_EQ(map.landmark(6), nullptr);
  EXPECT_EQ(map.landmark(12)->observations.back().keyframe, 7);
  EXPECT_LT(local(T * whole.keyframe(7)->T_odom_camera, map.keyframe(7)->T_odom_camera).norm(),
            1e-12);
  const std::int64_t made = map.keyframe(6)->landmark_of_feature[static_cast<std::size_t>(free)];
  EXPECT_EQ(map.landmark(made)->p_odom, part.landmark(id_in_part)->p_odom);
  EXPECT_EQ(whole.landmark(made), nullptr);  // an id of its own
  int own = 0;
  for (const auto& [id, landmark] : whole.landmarks()) {
    if (id < id_in_part) continue;
    EXPECT_LT((map.landmark(id)->p_odom - T * landmark.p_odom).norm(), 1e-12);
    ++own;
  }
  EXPECT_GT(own, 20);
}

TEST(LiveMapping, AResultThatComesLateIsAsGoodAsOneInTime) {
  const VisualOdometryConfig config;
  OneToCome late;
  LocalMapping mapping(late.m.camera, late.m.scales, config);
  mapping.start(make_mapping_job(late.m.map, 6, config));
  late.come();
  mapping.finish(&late.m.map);
  OneToCome in_time;
  mapping.start(make_mapping_job(in_time.m.map, 6, config));
  mapping.finish(&in_time.m.map);
  in_time.come();
  EXPECT_TRUE(consistent(late.m.map));
  for (int k = 1; k <= 6; ++k)
    EXPECT_EQ(late.m.map.keyframe(k)->T_odom_camera.matrix(),
              in_time.m.map.keyframe(k)->T_odom_camera.matrix());
  EXPECT_EQ(late.m.map.landmarks().size(), in_time.m.map.landmarks().size());
  const auto seen = [](const VisualMap& map) {
    const auto& of = map.keyframe(7)->landmark_of_feature;
    return of.size() - std::count(of.begin(), of.end(), 0);
  };
  EXPECT_EQ(seen(late.m.map), seen(in_time.m.map));
}

TEST(LiveMapping, TrackingNeverWaits) {
  const CameraModel camera = small_camera();
  const RenderedWall wall;
  VisualOdometryConfig config = small_config();
  config.wait_for_mapping = false;
  VisualOdometry odometry(camera, robot_with(SE3::Identity()), config);
  int keyframes = 0;
  SE3 T_before = SE3::Identity();
  for (int step = 0; step < 60; ++step) {  // as fast as it goes: the thread is often at work
    const TrackingResult result =
        odometry.track(wall.see(camera, walk(step), (step + 1) * kFrame_us));
    ASSERT_EQ(result.state, TrackingState::kOk) << step << " " << result.reason;
    const SE3 T_truth = walk(std::max(0, step - 1)).inverse() * walk(step);
    EXPECT_LT(local(T_truth, T_before.inverse() * result.T_odom_base).head<3>().norm(), 0.04);
    T_before = result.T_odom_base;
    keyframes += result.keyframe ? 1 : 0;
    ASSERT_TRUE(consistent(odometry.map())) << step;
  }
  EXPECT_GE(keyframes, 5);
  EXPECT_EQ(odometry.counts().mapping_waits, 0);
  EXPECT_LE(odometry.counts().mappings, keyframes);
}

// Keyframes that follow each other closely leave the thread no idle frame.
TEST(LiveMapping, TheGraphIsFollowedAtTheNextKeyframeHoweverCloselyTheyCome) {
  const CameraModel camera = small_camera();
  const RenderedWall wall;
  VisualOdometryConfig config = small_config();
  config.redundant_share = 2.0;
  config.keyframe_parallax = 0.001;
  VisualOdometry odometry(camera, robot_with(SE3::Identity()), config);
  const auto at = [](int i) { return from_xyz_rpy(0.03 * i - 0.4, 0.0, -1.6, 0.0, 0.0, 0.0); };
  std::map<std::int64_t, SE3> T_odom_base;
  const auto show = [&](int i) {
    const TrackingResult result = odometry.track(wall.see(camera, at(i), (i + 1) * kFrame_us));
    ASSERT_EQ(result.state, TrackingState::kOk) << i << " " << result.reason;
    ASSERT_TRUE(result.keyframe) << i;
    T_odom_base[result.keyframe->id] = result.T_odom_base;
  };
  const auto say = [&](const SE3& bend) {
    for (const auto& [id, T] : T_odom_base)
      odometry.add_graph_node(id, (id <= 3 ? bend : SE3::Identity()) * T);
  };
  for (int i = 0; i < 16; ++i) show(i);
  say(SE3::Identity());
  show(16);
  say(from_xyz_rpy(0.3, 0.2, 0.1, 0.0, 0.0, 0.1));
  show(17);
  EXPECT_EQ(odometry.counts().revised_keyframes, 3);
  EXPECT_TRUE(consistent(odometry.map()));
  show(18);
  const SE3 T_truth = at(16).inverse() * at(18);
  const SE3 T_moved = T_odom_base[17].inverse() * T_odom_base[19];
  EXPECT_LT(local(T_truth, T_moved).head<3>().norm(), 0.01);
}

}  // namespace
}  // namespace fusion_slam
