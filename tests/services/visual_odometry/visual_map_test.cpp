#include "services/visual_odometry/visual_map.hpp"

#include <gtest/gtest.h>

#include "tests/services/visual_odometry/made_up_map.hpp"

namespace fusion_slam {
namespace {

TEST(VisualMap, LinksStandAtBothEnds) {
  MadeUpMap m = make_map(3, 20, 0.0);
  EXPECT_TRUE(consistent(m.map));
  EXPECT_FALSE(m.map.link(1, 1, 0));  // that feature shows a landmark already
  m.map.unlink(1, 2);
  EXPECT_TRUE(consistent(m.map));
  m.map.erase_keyframe(3);
  EXPECT_TRUE(consistent(m.map));
  m.map.unlink(1, 1);
  EXPECT_EQ(m.map.landmark(1), nullptr);  // nobody sees it any more
  m.map.erase_landmark(2);
  EXPECT_TRUE(consistent(m.map));
}

TEST(VisualMap, MergingKeepsOneViewAKeyframe) {
  MadeUpMap m = make_map(3, 20, 0.0);
  m.map.unlink(4, 3);
  m.map.merge(4, 5);  // keyframes 1 and 2 see both, none sees 4 alone
  EXPECT_EQ(m.map.landmark(4), nullptr);
  EXPECT_EQ(m.map.landmark(5)->observations.size(), 3U);
  EXPECT_TRUE(consistent(m.map));
  m.map.unlink(6, 1);
  m.map.unlink(7, 2);
  m.map.unlink(7, 3);
  m.map.merge(7, 6);  // 7 was seen by keyframe 1 only, 6 by 2 and 3
  EXPECT_EQ(m.map.landmark(6)->observations.size(), 3U);
  EXPECT_TRUE(consistent(m.map));
}

TEST(VisualMap, APartPutBackIsAsIfTheWholeHadBeenChanged) {
  MadeUpMap whole = make_map(5, 60, 0.0);
  whole.map.unlink(8, 4);
  whole.map.unlink(8, 5);
  for (const std::int64_t k : {1, 2, 3}) whole.map.unlink(9, k);
  VisualMap direct = whole.map;
  const VisualMap before = whole.map.copy_part({2, 3, 4}, {2, 3});
  VisualMap part = before;
  for (VisualMap* map : {&direct, &part}) {
    map->erase_landmark(3);
    map->merge(10, 11);
    map->unlink(12, 3);
    map->landmark(13)->p_odom.x() += 1.0;
    map->keyframe(3)->T_odom_camera.translation().x() += 1.0;
    map->erase_keyframe(4);
  }
  whole.map.landmark(13)->found = 7;  // tracking went on meanwhile
  whole.map.put_back(before, part);
  EXPECT_TRUE(consistent(whole.map));
  EXPECT_EQ(whole.map.landmark(13)->found, 7);
  ASSERT_EQ(whole.map.landmarks().size(), direct.landmarks().size());
  ASSERT_EQ(whole.map.keyframes().size(), direct.keyframes().size());
  for (const auto& [id, landmark] : direct.landmarks()) {
    const Landmark* other = whole.map.landmark(id);
    ASSERT_NE(other, nullptr) << id;
    EXPECT_EQ(other->p_odom, landmark.p_odom);
    ASSERT_EQ(other->observations.size(), landmark.observations.size()) << id;
  }
  for (const auto& [id, keyframe] : direct.keyframes())
    EXPECT_EQ(whole.map.keyframe(id)->landmark_of_feature, keyframe.landmark_of_feature) << id;
}

}  // namespace
}  // namespace fusion_slam
