// A dense mapper that can't keep up: how often it follows, what it leaves out, and that what it
// left out neither waits for ever nor comes back after a restart.
#include "services/dense_mapper/pace.hpp"

#include <gtest/gtest.h>

#include "services/dense_mapper/dense_mapper.hpp"
#include "tests/services/dense_mapper/synthetic_room.hpp"

namespace fusion_slam {
namespace {

TEST(Pace, FollowsForAQuarterOfTheTimeAndForASixteenthWhenBehind) {
  Pace pace;
  EXPECT_TRUE(pace.may_follow(10.0));
  pace.followed(10.0, 0.5, 1, 0);
  EXPECT_FALSE(pace.may_follow(11.4));
  EXPECT_TRUE(pace.may_follow(11.5));
  pace.followed(12.0, 0.5, 1, 1000);
  EXPECT_FALSE(pace.may_follow(19.4));
  EXPECT_TRUE(pace.may_follow(19.5));
}

TEST(Pace, AStepTakesATenthOfASecondWhateverACubeCosts) {
  for (const double cube_s : {0.0002, 0.001, 0.01}) {
    Pace pace;
    double cost_s = 0.0;
    for (int i = 0; i < 12; ++i) {
      cost_s = cube_s * static_cast<double>(pace.cubes_a_step());
      pace.followed(i, cost_s, pace.cubes_a_step(), 0);
    }
    EXPECT_LT(cost_s, 0.2) << cube_s;
    EXPECT_GT(cost_s, 0.03) << cube_s;
    const std::size_t cubes = pace.cubes_a_step();
    pace.followed(20.0, 0.001, 1, 0);
    EXPECT_EQ(pace.cubes_a_step(), cubes) << "a step with little to do says nothing";
  }
}

TEST(Pace, MapsTheFewerSubmapsTheLongerTheQueue) {
  const auto mapped_of_64 = [](std::size_t queue) {
    Pace pace;
    int n = 0;
    for (int i = 0; i < 64; ++i) n += pace.maps_next(queue) ? 1 : 0;
    return n;
  };
  EXPECT_EQ(mapped_of_64(0), 64);
  EXPECT_EQ(mapped_of_64(65), 32);
  EXPECT_EQ(mapped_of_64(129), 16);
  EXPECT_EQ(mapped_of_64(1'000'000), 1);
}

class LeaveOut : public testing::Test {
 protected:
  LeaveOut() { mapper_.keep_changes(); }
  static DenseMapperConfig config() {
    DenseMapperConfig config;
    config.keyframes_per_submap = 2;
    return config;
  }
  void offer(std::int64_t id, DenseMapper* mapper) const {
    EXPECT_TRUE(mapper->add_keyframe(id, render_room(robot_.T_base_camera, camera_, id)));
  }
  void see(std::int64_t id, const SE3& T_map_base) {
    offer(id, &mapper_);
    mapper_.set_pose(id, T_map_base, id);
    mapper_.integrate_ready();
    mapper_.update(false);
  }

  RobotModel robot_ = robot_with_camera_at(0.0);
  CameraModel camera_ = small_camera();
  DenseMapperConfig config_ = config();
  DenseMapper mapper_{camera_, robot_, config_};
};

TEST_F(LeaveOut, OnlyWhereAClosedSubmapLooksTheSameWay) {
  const SE3 here = SE3::Identity();
  see(1, here);
  mapper_.set_pose(3, here, 3);
  EXPECT_FALSE(mapper_.repeats_a_place(3)) << "the first is open";
  see(2, here);
  EXPECT_TRUE(mapper_.repeats_a_place(3));
  EXPECT_FALSE(mapper_.repeats_a_place(4)) << "no submap begins with it";
  mapper_.set_pose(3, from_xyz_rpy(0, 0, 0, 0, 0, 1.0), 3);
  EXPECT_FALSE(mapper_.repeats_a_place(3));
  mapper_.set_pose(3, from_xyz_rpy(1, 0, 0, 0, 0, 0), 3);
  EXPECT_FALSE(mapper_.repeats_a_place(3));
}

TEST_F(LeaveOut, AWholeSubmapCountsAsMappedAlsoAfterARestart) {
  for (int id = 1; id <= 2; ++id) see(id, SE3::Identity());
  const auto bytes = mapper_.map_bytes();
  SavedMap saved;
  const SavedBytes first = mapper_.take_changes();
  ASSERT_TRUE(read_saved(first.data(), first.size(), &saved));

  offer(4, &mapper_);  // looked at while its submap's first waits
  for (int id = 3; id <= 4; ++id) mapper_.set_pose(id, SE3::Identity(), id);
  mapper_.leave_out(3);
  EXPECT_EQ(mapper_.waiting(), 0U);
  EXPECT_TRUE(mapper_.has(3) && mapper_.has(4));
  EXPECT_TRUE(mapper_.belongs_to_left_out(4));
  EXPECT_FALSE(mapper_.belongs_to_left_out(2) || mapper_.belongs_to_left_out(5));
  mapper_.integrate_ready();
  mapper_.update(false);
  EXPECT_EQ(mapper_.map_bytes(), bytes);
  EXPECT_TRUE(mapper_.needed_images().empty());

  const SavedBytes then = mapper_.take_changes();
  ASSERT_FALSE(then.empty());
  ASSERT_TRUE(read_saved(then.data(), then.size(), &saved));
  DenseMapper again(camera_, robot_, config_);
  ASSERT_TRUE(again.restore(std::move(saved)));
  EXPECT_EQ(again.integrated(), 4U);
  EXPECT_TRUE(again.has(3) && again.has(4) && again.belongs_to_left_out(4));
}

TEST_F(LeaveOut, MovesWaitUntilTheyMayBeFollowedOrTheMapIsFinished) {
  for (int id = 1; id <= 2; ++id) see(id, SE3::Identity());
  const std::int64_t late_us = 2 * config_.moved_period_us;
  mapper_.follow_moves(false);
  mapper_.set_pose(1, from_xyz_rpy(1, 0, 0, 0, 0, 0), late_us);
  EXPECT_FALSE(mapper_.due());
  EXPECT_TRUE(mapper_.update(false).octomap.empty());
  EXPECT_EQ(mapper_.cubes_followed(), 0U);
  mapper_.follow_moves(true);
  EXPECT_TRUE(mapper_.due());
  EXPECT_FALSE(mapper_.update(false).octomap.empty());
  EXPECT_GT(mapper_.cubes_followed(), 0U);
  mapper_.follow_moves(false);
  mapper_.set_pose(1, SE3::Identity(), 2 * late_us);
  EXPECT_FALSE(mapper_.update(true).octomap.empty());
}

}  // namespace
}  // namespace fusion_slam
