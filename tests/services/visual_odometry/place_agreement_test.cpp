// Old places are used where they agree with what is tracked.
#include "services/visual_odometry/place_agreement.hpp"

#include <gtest/gtest.h>

#include "services/visual_odometry/local_map.hpp"
#include "tests/services/visual_odometry/made_up_map.hpp"

namespace fusion_slam {
namespace {

bool first_agrees_with_last(const MadeUpMap& m, const VisualOdometryConfig& config = {}) {
  const MapKeyframe& now = m.map.keyframes().rbegin()->second;
  const FeatureGrid grid(now.features->features, m.camera.width_px, m.camera.height_px);
  return agrees(m.map, *m.map.keyframe(1), now, grid, m.camera, m.scales, config);
}

// What drift does: the newest keyframe believes to be elsewhere.
void drift(double metres, MadeUpMap* m) {
  MapKeyframe* now = m->map.keyframe(m->map.keyframes().rbegin()->first);
  now->T_odom_camera.translation().x() += metres;
}

TEST(PlaceAgreement, NoiseAgreesAndDriftDoesNot) {
  MadeUpMap m = make_map(5, 80, 1.0);
  EXPECT_TRUE(first_agrees_with_last(m));
  drift(0.002, &m);
  EXPECT_TRUE(first_agrees_with_last(m));
  drift(0.05, &m);
  EXPECT_FALSE(first_agrees_with_last(m));
}

TEST(PlaceAgreement, AFewLandmarksProveNothing) {
  MadeUpMap m = make_map(3, 14, 0.0);
  EXPECT_FALSE(first_agrees_with_last(m));
  VisualOdometryConfig config;
  config.agree_landmarks = 8;
  EXPECT_TRUE(first_agrees_with_last(m, config));
}

TEST(PlaceAgreement, TheLocalMapLeavesOutPlacesThatDisagree) {
  MadeUpMap m = make_map(6, 80, 0.0);
  VisualOdometryConfig config;
  config.local_recent_keyframes = 2;
  config.local_covisible_keyframes = 0;
  const auto local = [&] {
    const SE3& T = m.map.keyframe(6)->T_odom_camera;
    return local_keyframes(m.map, 1, T, m.camera, m.scales, config);
  };
  EXPECT_EQ(local(), (std::vector<std::int64_t>{1, 2, 3, 4, 5, 6}));
  config.local_near_keyframes = 1;  // the nearest
  EXPECT_EQ(local(), (std::vector<std::int64_t>{4, 5, 6}));
  config.local_near_keyframes = 10;
  drift(0.05, &m);
  EXPECT_EQ(local(), (std::vector<std::int64_t>{5, 6}));
}

}  // namespace
}  // namespace fusion_slam
