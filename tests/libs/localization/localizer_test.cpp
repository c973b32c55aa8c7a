#include "libs/localization/localizer.hpp"

#include <gtest/gtest.h>

#include "tests/libs/localization/flat_world.hpp"
#include "tests/services/loop_detector/made_up_places.hpp"

namespace fusion_slam {
namespace {

using State = LocalizationState;

const SE2 kMapWorld{-2.0, 0.5, 0.4};
const SE3 kOdomWorld = from_xyz_rpy(3.0, -7.0, 0, 0, 0, -1.2);  // as the tracker began anywhere

RobotModel robot() {
  RobotModel robot;
  robot.has_lidar = true;
  robot.has_camera = true;
  return robot;
}

LocalScan scan_at(const FlatWorld& world, const SE2& T_world_base, std::int64_t id) {
  LocalScan scan;
  scan.id = id;
  scan.utime_us = id * 200'000;
  scan.T_odom_base = kOdomWorld * to_se3(T_world_base);
  scan.starts_anew = id == 1;
  scan.points_base = scan_of(world, T_world_base, static_cast<unsigned>(id));
  return scan;
}

double error_m(const SE3& T_map_base, const SE2& T_world_base) {
  const SE2 truth = kMapWorld * T_world_base;
  return std::hypot(T_map_base.translation().x() - truth.x, T_map_base.translation().y() - truth.y);
}

LocalizationMap lidar_map(const FlatWorld& world) {
  LocalizationMap map(robot(), std::nullopt);
  map.set_grid(grid_of(world, kMapWorld));
  return map;
}

// What the camera saw when the map was made at `at` of the world, and sees `later`.
struct Views {
  explicit Views(const SE2& at) : T_map_base(to_se3(kMapWorld * at)), place(make_place(7)) {}
  MapView of_map() const { return {T_map_base, see_place(place, camera, SE3::Identity(), 1)}; }
  LocalView now(const SE3& T_then_now, std::int64_t id, const SE2& T_world_base) const {
    LocalView view;
    view.id = id;
    view.utime_us = id * 200'000;
    view.T_odom_base = to_se3(T_world_base);
    view.starts_anew = id == 1;
    view.features = see_place(place, camera, T_then_now, 2 + static_cast<unsigned>(id));
    return view;
  }
  CameraModel camera;
  SE3 T_map_base;
  MadeUpPlace place;
};

TEST(Localizer, ByLidarAloneAfterSomeWay) {
  const FlatWorld world = flat();
  const LocalizationMap map = lidar_map(world);
  Localizer localizer(map);
  EXPECT_EQ(localizer.state(), State::kUnknown);
  bool was_candidate = false;
  std::int64_t id = 0;
  const auto way = way_through();
  for (const SE2& T_world_base : way) {
    localizer.add_scan(scan_at(world, T_world_base, ++id));
    was_candidate |= localizer.state() == State::kCandidate;
    if (localizer.state() == State::kLocalized) {
      ASSERT_TRUE(localizer.here());
      EXPECT_LT(error_m(localizer.here()->T_map_base, T_world_base), 0.05);
    }
  }
  EXPECT_TRUE(was_candidate);
  EXPECT_EQ(localizer.state(), State::kLocalized);
  ASSERT_EQ(localizer.placed().size(), way.size());  // the way before the fix, too
  for (const auto& [node, placed] : localizer.placed())
    EXPECT_LT(error_m(placed.T_map_base, way[static_cast<std::size_t>(node.id - 1)]), 0.06);
  EXPECT_EQ(localizer.take_placed().size(), way.size());
  EXPECT_TRUE(localizer.take_placed().empty());
  EXPECT_GT(localizer.take_fixes().size(), 5U);
}

TEST(Localizer, NeverInARoomThatLooksAlikeFromTwoSides) {
  const FlatWorld world = bare_room();
  const LocalizationMap map = lidar_map(world);
  Localizer localizer(map);
  for (std::int64_t id = 1; id <= 10; ++id) {
    localizer.add_scan(scan_at(world, {2.0 + 0.35 * static_cast<double>(id), 2.0, 0.2}, id));
    ASSERT_NE(localizer.state(), State::kLocalized) << localizer.reason();
  }
  EXPECT_EQ(localizer.state(), State::kCandidate);
}

TEST(Localizer, BothSensorsAgreeAtOnce) {
  const FlatWorld world = bare_room();  // the LiDAR alone could not tell
  const SE2 here{3.0, 2.0, 0.2};
  const Views views(here);
  LocalizationMap map(robot(), views.camera);
  map.set_grid(grid_of(world, kMapWorld));
  map.add_view(1, views.of_map());
  Localizer localizer(map);
  localizer.add_scan(scan_at(world, here, 1));
  EXPECT_EQ(localizer.state(), State::kCandidate);
  localizer.add_view(views.now(SE3::Identity(), 1, here));
  EXPECT_EQ(localizer.state(), State::kLocalized) << localizer.reason();
  EXPECT_LT(error_m(localizer.here()->T_map_base, here), 0.05);
}

TEST(Localizer, NotWhenTheyContradictEachOther) {
  const FlatWorld world = flat();
  const Views views({7.5, 3.0, 1.0});  // the view was seen in the other room
  LocalizationMap map(robot(), views.camera);
  map.set_grid(grid_of(world, kMapWorld));
  map.add_view(1, views.of_map());
  Localizer localizer(map);
  const auto way = way_through();
  for (std::int64_t id = 1; id <= 4; ++id) {
    const SE2& here = way[static_cast<std::size_t>(id - 1)];
    localizer.add_scan(scan_at(world, here, id));
    localizer.add_view(views.now(SE3::Identity(), id, here));
    ASSERT_NE(localizer.state(), State::kLocalized) << localizer.reason();
  }
  EXPECT_EQ(localizer.reason(), "camera and LiDAR name different places");
}

TEST(Localizer, ByCameraAloneWhenTwoViewsAgree) {
  RobotModel camera_robot;
  camera_robot.has_camera = true;
  const SE2 here{3.0, 2.0, 0.2};
  const Views views(here);
  LocalizerConfig config;
  config.camera_sure_inliers = 100'000;  // so that one view is never enough
  LocalizationMap map(camera_robot, views.camera, config);
  map.add_view(1, views.of_map());
  Localizer localizer(map);
  localizer.add_view(views.now(SE3::Identity(), 1, {0, 0, 0}));
  EXPECT_EQ(localizer.state(), State::kCandidate) << localizer.reason();
  const SE3 moved = from_xyz_rpy(0.15, 0.05, 0, 0, 0, 0.1);
  localizer.add_view(views.now(moved, 2, to_se2(moved)));
  ASSERT_EQ(localizer.state(), State::kLocalized) << localizer.reason();
  const SE3 truth = views.T_map_base * moved;
  EXPECT_LT((localizer.here()->T_map_base.translation() - truth.translation()).norm(), 0.05);
  localizer.add_view(views.now(moved, 3, to_se2(moved)));
  EXPECT_EQ(localizer.placed().size(), 3U);
}

TEST(Localizer, ARobotWithoutTheMapsCameraFollowsTheLidarsRules) {
  const FlatWorld world = flat();
  const Views views({3.0, 2.0, 0.2});
  LocalizationMap map(robot(), views.camera);
  map.set_grid(grid_of(world, kMapWorld));
  map.add_view(1, views.of_map());
  Localizer localizer(map);
  localizer.set_sensors(true, false);
  std::int64_t id = 0;
  for (const SE2& T_world_base : way_through())
    if (localizer.state() != State::kLocalized)
      localizer.add_scan(scan_at(world, T_world_base, ++id));
  EXPECT_EQ(localizer.state(), State::kLocalized) << localizer.reason();
}

TEST(Localizer, TakesAHintThatFits) {
  const FlatWorld world = flat();
  const LocalizationMap map = lidar_map(world);
  Localizer localizer(map);
  const SE2 here{2.0, 1.8, 0.3};
  std::string why;
  EXPECT_FALSE(localizer.hint(kMapWorld * here, &why));
  localizer.add_scan(scan_at(world, here, 1));
  EXPECT_FALSE(localizer.hint(kMapWorld * SE2{7.8, 3.6, -1.0}, &why));
  EXPECT_FALSE(why.empty());
  EXPECT_NE(localizer.state(), State::kLocalized);
  EXPECT_TRUE(localizer.hint(kMapWorld * SE2{2.4, 1.5, 0.5}, &why)) << why;
  EXPECT_EQ(localizer.state(), State::kLocalized);
  EXPECT_LT(error_m(localizer.here()->T_map_base, here), 0.05);
}

TEST(Localizer, SaysSoWhenScansContradictTheMap) {
  const FlatWorld world = flat();
  const LocalizationMap map = lidar_map(world);
  Localizer localizer(map);
  const auto way = way_through();
  std::int64_t id = 0;
  for (const SE2& T_world_base : way)
    if (localizer.state() != State::kLocalized)
      localizer.add_scan(scan_at(world, T_world_base, ++id));
  ASSERT_EQ(localizer.state(), State::kLocalized);
  FlatWorld other;  // carried into another building
  other.walls = {
      {{0, 0}, {2.1, 0.4}}, {{2.1, 0.4}, {2.6, 2}}, {{2.6, 2}, {0.5, 2.9}}, {{0.5, 2.9}, {0, 0}}};
  for (int n = 0; n < 12 && localizer.state() == State::kLocalized; ++n) {
    LocalScan scan = scan_at(world, way.back(), ++id);
    scan.points_base = scan_of(other, {1.2, 1.2, 0.3}, 5);
    localizer.add_scan(scan);
  }
  EXPECT_NE(localizer.state(), State::kLocalized);
}

TEST(Localizer, StartsFromNothingWhenTheTrackBreaks) {
  const FlatWorld world = flat();
  const LocalizationMap map = lidar_map(world);
  Localizer localizer(map);
  std::int64_t id = 0;
  for (const SE2& T_world_base : way_through())
    if (localizer.state() != State::kLocalized)
      localizer.add_scan(scan_at(world, T_world_base, ++id));
  ASSERT_EQ(localizer.state(), State::kLocalized);
  localizer.lidar_lost();
  EXPECT_EQ(localizer.state(), State::kUnknown);
  EXPECT_FALSE(localizer.here());
  EXPECT_EQ(localizer.reason(), "the LiDAR lost its track");
}

}  // namespace
}  // namespace fusion_slam
