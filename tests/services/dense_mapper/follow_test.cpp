// A map that follows its submaps a few cubes at a time ends as the one that follows at once, also
// when it goes on mapping meanwhile, or is killed on the way.
#include <gtest/gtest.h>

#include "services/dense_mapper/dense_mapper.hpp"
#include "tests/services/dense_mapper/published.hpp"
#include "tests/services/dense_mapper/synthetic_room.hpp"

namespace fusion_slam {
namespace {

constexpr int kViews = 8;

class Follow : public testing::Test {
 protected:
  static DenseMapperConfig config() {
    DenseMapperConfig config;
    config.keyframes_per_submap = 2;
    config.submaps_that_count = 100;  // the base is then what its submaps add up to
    return config;
  }
  static SE3 view(int id) { return from_xyz_rpy(-0.1 * id, 0.05 * id, 0, 0, 0, 0.06 * (id % 5)); }
  static SE3 bent(int id) { return from_xyz_rpy(0.2, 0.1, 0, 0, 0, 0.02) * view(id); }

  DenseMapper mapper() const {
    DenseMapper mapper(camera_, robot_, config());
    mapper.keep_changes();
    return mapper;
  }
  void see(int id, const SE3& T_map_base, DenseMapper* mapper) {
    EXPECT_TRUE(mapper->add_keyframe(
        id, render_room(view(id) * robot_.T_base_camera, camera_, id * 1'000'000)));
    mapper->set_pose(id, T_map_base, id * 1'000'000);
    mapper->integrate_ready();
    map_.add(mapper->update(false));
  }
  void drive(DenseMapper* mapper) {
    map_ = {};
    for (int id = 1; id <= kViews; ++id) see(id, view(id), mapper);
  }
  static void bend(DenseMapper* mapper, std::int64_t utime_us) {
    for (int id = 1; id <= kViews; ++id) mapper->set_pose(id, bent(id), utime_us);
  }
  int follow(DenseMapper* mapper) {
    int steps = 0;
    for (; mapper->due() && steps < 1000; ++steps) map_.add(mapper->update(false));
    return steps;
  }
  RobotModel robot_ = robot_with_camera_at(0.1);
  CameraModel camera_ = small_camera();
  Published map_;  // of the mapper at work
};

TEST_F(Follow, InStepsTheMapEndsAsAtOnce) {
  DenseMapper whole = mapper();
  drive(&whole);
  const Published before = map_;
  bend(&whole, 20'000'000);
  EXPECT_EQ(follow(&whole), 1);
  const Published at_once = map_;
  ASSERT_FALSE(before == at_once) << "the test is to move something";
  const std::size_t cubes = whole.cubes_followed();

  DenseMapper stepwise = mapper();
  drive(&stepwise);
  stepwise.follow_at_most(2);
  bend(&stepwise, 20'000'000);
  EXPECT_EQ(follow(&stepwise), static_cast<int>((cubes + 1) / 2));
  EXPECT_EQ(stepwise.cubes_followed(), cubes) << "each once";
  EXPECT_TRUE(map_ == at_once);
}

TEST_F(Follow, WhatIsMappedAndMovesMeanwhileIsInItToo) {
  const auto twice = [&](std::size_t cubes_a_step) {
    DenseMapper mapper = this->mapper();
    drive(&mapper);
    mapper.follow_at_most(cubes_a_step);
    bend(&mapper, 20'000'000);
    map_.add(mapper.update(false));
    for (int id = kViews + 1; id <= kViews + 4; ++id) see(id, bent(id), &mapper);
    mapper.set_pose(1, from_xyz_rpy(0, 0.3, 0, 0, 0, 0) * bent(1), 30'000'000);
    follow(&mapper);
    return map_;
  };
  const Published at_once = twice(1000);
  const Published in_steps = twice(1);
  EXPECT_TRUE(in_steps.octomap == at_once.octomap);
  EXPECT_TRUE(in_steps.cloud == at_once.cloud);
  EXPECT_TRUE(in_steps.grid == at_once.grid);
}

TEST_F(Follow, WhoMayNotFollowMapsOn) {
  DenseMapper mapper = this->mapper();
  drive(&mapper);
  mapper.follow_at_most(1);
  bend(&mapper, 20'000'000);
  map_.add(mapper.update(false));
  const std::size_t cubes = mapper.cubes_followed();
  mapper.follow_moves(false);
  EXPECT_FALSE(mapper.due());
  see(kViews + 1, bent(kViews + 1), &mapper);
  EXPECT_EQ(mapper.cubes_followed(), cubes);
  EXPECT_EQ(mapper.integrated(), kViews + 1U);
  map_.add(mapper.update(true));
  EXPECT_FALSE(mapper.due()) << "the final map follows all";
}

TEST_F(Follow, KilledOnTheWayItGoesOnFromThere) {
  DenseMapper mapper = this->mapper();
  drive(&mapper);
  mapper.follow_at_most(2);
  bend(&mapper, 20'000'000);
  std::vector<SavedBytes> records;
  mapper.write_all([&](const SavedBytes& bytes) { records.push_back(bytes); });
  std::vector<std::size_t> killed_after;
  while (mapper.due()) {
    map_.add(mapper.update(false));
    records.push_back(mapper.take_changes());
    killed_after.push_back(records.size());
  }
  const Published undisturbed = map_;
  ASSERT_GT(killed_after.size(), 3U);
  for (const std::size_t n : killed_after) {
    SavedMap saved;
    for (std::size_t i = 0; i < n; ++i)
      ASSERT_TRUE(read_saved(records[i].data(), records[i].size(), &saved));
    EXPECT_EQ(saved.dirty_base.empty(), n == records.size());
    DenseMapper again = this->mapper();
    ASSERT_TRUE(again.restore(std::move(saved)));
    bend(&again, 20'000'000);
    map_ = {};
    map_.add(again.update(false));
    follow(&again);
    EXPECT_TRUE(map_ == undisturbed);
  }
}

}  // namespace
}  // namespace fusion_slam
