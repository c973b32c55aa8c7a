#include "services/visual_odometry/thinning.hpp"

#include <random>
#include <set>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;

MapKeyframe keyframe_at(std::int64_t id, std::int64_t utime_us, double x_m, double yaw_rad) {
  MapKeyframe keyframe;
  keyframe.id = id;
  keyframe.utime_us = utime_us;
  keyframe.segment = 1;
  // The optical axis lies in the plane.
  keyframe.T_odom_camera = from_xyz_rpy(x_m, 0.0, 0.0, 0.0, 0.0, yaw_rad) *
                           from_xyz_rpy(0.0, 0.0, 0.0, -M_PI / 2.0, 0.0, -M_PI / 2.0);
  auto features = std::make_shared<FeatureSet>();
  features->features.resize(1);
  features->descriptors.resize(1);
  keyframe.features = features;
  keyframe.landmark_of_feature.assign(1, 0);
  return keyframe;
}

// To and fro on 20 m, a keyframe each half metre and each 5 s.
struct Drive {
  VisualOdometryConfig config;
  VisualMap map;
  KeyframeThinning thinning;
  std::int64_t id = 0;

  void metres(int n) {
    for (int i = 0; i < 2 * n; ++i) {
      ++id;
      const std::int64_t step = id % 80;
      const bool back = step >= 40;
      map.add_keyframe(
          keyframe_at(id, id * 5 * kSecond_us, 0.5 * (back ? 80 - step : step), back ? M_PI : 0.0));
      map.link(map.add_landmark({}), id, 0);
      thinning.thin(id, config, &map);
    }
  }
};

TEST(KeyframeThinning, TheMapStopsGrowing) {
  Drive drive;
  drive.metres(400);
  const std::size_t after_ten_rounds = drive.map.keyframes().size();
  drive.metres(1200);
  EXPECT_LE(drive.map.keyframes().size(), after_ten_rounds + 4);
  EXPECT_EQ(drive.map.landmarks().size(), drive.map.keyframes().size());
}

TEST(KeyframeThinning, WhatIsYoungOrWasSeenFewTimesStays) {
  Drive drive;
  drive.config.thin_m = 0.4;  // each place for itself
  drive.metres(120);          // three rounds
  EXPECT_EQ(drive.map.keyframes().size(), 240U);

  Drive young;
  young.config.thin_age_us = 100'000 * kSecond_us;
  young.metres(200);
  EXPECT_EQ(young.map.keyframes().size(), 400U);
}

// However long the drive: where a keyframe was made there are as many as shall stay.
TEST(KeyframeThinning, EveryPlaceIsStillThere) {
  Drive drive;
  drive.metres(800);
  const std::int64_t last_old = drive.id - drive.config.thin_age_us / (5 * kSecond_us);
  for (std::int64_t id = 1; id <= last_old; ++id) {
    const bool back = id % 80 >= 40;
    const double x_m = 0.5 * static_cast<double>(back ? 80 - id % 80 : id % 80);
    int n = 0;
    for (const auto& [other, keyframe] : drive.map.keyframes()) {
      const double apart_m = std::abs(keyframe.T_odom_camera.translation().x() - x_m);
      n += apart_m <= drive.config.thin_m + 1e-9 && (other % 80 >= 40) == back ? 1 : 0;
    }
    EXPECT_GE(n, drive.config.thin_older) << id;
  }
}

TEST(KeyframeThinning, SegmentsDirectionsAndTheReferenceAreApart) {
  VisualOdometryConfig config;
  const auto run = [&](const std::function<void(MapKeyframe*)>& change, std::int64_t reference) {
    VisualMap map;
    KeyframeThinning thinning;
    for (std::int64_t id = 1; id <= 40; ++id) {
      MapKeyframe keyframe = keyframe_at(id, id * 100 * kSecond_us, 0.0, 0.0);
      change(&keyframe);
      map.add_keyframe(keyframe);
      thinning.thin(reference, config, &map);
    }
    std::set<std::int64_t> ids;
    for (const auto& [id, keyframe] : map.keyframes()) ids.insert(id);
    return ids;
  };
  const auto nothing = [](MapKeyframe*) {};
  // The two oldest, of the old ones the two newest, and what is not settled.
  std::set<std::int64_t> expected{1, 2, 28, 29};
  for (std::int64_t id = 30; id <= 40; ++id) expected.insert(id);
  EXPECT_EQ(run(nothing, 40), expected);
  expected.insert(7);
  EXPECT_EQ(run(nothing, 7), expected);
  EXPECT_EQ(run([](MapKeyframe* k) { k->segment = static_cast<int>(k->id); }, 40).size(), 40U);
  const auto turned = [](MapKeyframe* k) {
    *k = keyframe_at(k->id, k->utime_us, 0.0, static_cast<double>(k->id % 4) * M_PI / 2.0);
  };
  EXPECT_EQ(run(turned, 40).size(), 11U + 4U * 4U);
}

}  // namespace
}  // namespace fusion_slam
