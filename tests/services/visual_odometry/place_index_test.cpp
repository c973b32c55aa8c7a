#include "services/visual_odometry/place_index.hpp"

#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

constexpr int kLandmarks = 500;  // of a keyframe

FeatureSet random_view(std::mt19937* random) {
  FeatureSet set;
  set.features.resize(kLandmarks);
  for (int i = 0; i < kLandmarks; ++i) {
    Descriptor d;
    for (auto& word : d) word = static_cast<std::uint64_t>((*random)()) << 32U | (*random)();
    set.descriptors.push_back(d);
  }
  return set;
}

// A keyframe of its own, whose features are all landmarks that were born there.
void add_keyframe(std::int64_t id, FeatureSet set, VisualMap* map) {
  MapKeyframe keyframe;
  keyframe.id = id;
  keyframe.segment = 1;
  keyframe.landmark_of_feature.assign(set.size(), 0);
  keyframe.features = std::make_shared<const FeatureSet>(std::move(set));
  const FeatureSet& seen = *keyframe.features;
  map->add_keyframe(keyframe);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    Landmark landmark;
    landmark.born = id;
    landmark.descriptor = seen.descriptors[i];
    map->link(map->add_landmark(landmark), id, static_cast<int>(i));
  }
}

TEST(PlaceIndex, GrowsWithTheMapNotWithTime) {
  std::mt19937 random(3);
  VisualMap map;
  PlaceIndex places;
  std::map<std::int64_t, FeatureSet> kept;
  for (std::int64_t id = 1; id <= 400; ++id) {
    FeatureSet set = random_view(&random);
    if (id % 40 == 0) kept[id] = set;
    add_keyframe(id, std::move(set), &map);
    places.add(map, id);
    if (id % 40 != 0) map.erase_keyframe(id);
    ASSERT_LE(places.size(), 65536U + kLandmarks);
  }
  for (const auto& [id, set] : kept) {
    const std::vector<std::int64_t> similar = places.similar(map, set, kNoSegment, 3);
    ASSERT_FALSE(similar.empty()) << id;
    EXPECT_EQ(similar.front(), id);
  }
}

}  // namespace
}  // namespace fusion_slam
