#include "services/pose_graph/landmark_store.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

SeenFeature feature(int index, std::int64_t landmark, float depth_m = 2.0F) {
  SeenFeature f;
  f.index = index;
  f.landmark = landmark;
  f.depth_m = depth_m;
  return f;
}

std::vector<std::int64_t> keyframes_of(const Track& track) {
  std::vector<std::int64_t> ids;
  for (const Sight& sight : track) ids.push_back(sight.keyframe);
  return ids;
}

TEST(LandmarkStore, TracksAreThePointsSeenTwiceAndOnceWithDepth) {
  LandmarkStore store;
  store.add(1, {feature(0, 7), feature(2, 8, 0.0F), feature(5, 9)});
  store.add(2, {feature(1, 7, 0.0F), feature(3, 8, 0.0F)});
  store.add(4, {feature(0, 7)});
  const auto tracks = store.tracks({}, {});
  ASSERT_EQ(tracks.size(), 1U);  // 8 has no depth, 9 was seen once
  EXPECT_EQ(keyframes_of(tracks[0]), (std::vector<std::int64_t>{1, 2, 4}));
}

TEST(LandmarkStore, ALoopMakesOnePointOfTwoAndOfMore) {
  LandmarkStore store;
  store.add(1, {feature(0, 7)});
  store.add(2, {feature(0, 7)});
  store.add(8, {feature(3, 20)});
  store.add(9, {feature(4, 30), feature(6, 7)});  // two names in one view: one sight
  EXPECT_EQ(keyframes_of(store.tracks({}, {})[0]), (std::vector<std::int64_t>{1, 2, 9}));
  const auto joined = store.tracks({{1, 8, {{0, 3}}}, {8, 9, {{3, 4}}}}, {});
  ASSERT_EQ(joined.size(), 1U);
  EXPECT_EQ(keyframes_of(joined[0]), (std::vector<std::int64_t>{1, 2, 8, 9}));
  // Pairs that name unknown keyframes or features say nothing.
  EXPECT_EQ(store.tracks({{1, 77, {{0, 3}}}, {1, 8, {{0, 99}}}}, {}).size(), 1U);
}

TEST(LandmarkStore, EachKeyframeGetsItsShareAndTheLongTracksFirst) {
  LandmarkStore store;
  for (std::int64_t k = 1; k <= 10; ++k) {
    std::vector<SeenFeature> seen;
    for (int i = 0; i < 200; ++i)  // landmark i is seen by keyframes up to 2 + i % 9
      if (k <= 2 + i % 9) seen.push_back(feature(i, i + 1));
    store.add(k, seen);
  }
  TrackLimits limits;
  limits.most_views = 300;
  limits.least_per_keyframe = 20;
  limits.most_per_track = 5;
  const auto tracks = store.tracks({}, limits);
  std::map<std::int64_t, int> count;
  for (const Track& track : tracks) {
    EXPECT_LE(track.size(), 5U);
    for (const Sight& sight : track) ++count[sight.keyframe];
  }
  for (std::int64_t k = 1; k <= 10; ++k) EXPECT_GE(count[k], 10) << k;
  EXPECT_LT(tracks.size(), 200U);
  for (std::size_t i = 1; i < tracks.size(); ++i) EXPECT_LE(tracks[i].size(), tracks[i - 1].size());
}

}  // namespace
}  // namespace fusion_slam
