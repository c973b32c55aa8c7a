// The worlds in config/worlds: closed, with a safe route, and with what each was made for.
#include <algorithm>
#include <filesystem>
#include <set>

#include <gmock/gmock.h>

#include "drivers/simulator/drive.hpp"
#include "drivers/simulator/truth_map.hpp"
#include "drivers/simulator/world.hpp"

namespace fusion_slam {
namespace {

const std::filesystem::path kWorlds = std::filesystem::path(FS_SOURCE_DIR) / "config/worlds";

TruthMap truth_of(const World& world) {
  return make_truth_map(world.boxes, {}, world.route_m.front(), TruthOptions{});
}

class EveryWorld : public testing::TestWithParam<std::string> {};

TEST_P(EveryWorld, IsClosedAndItsRouteKeepsAwayFromObstacles) {
  const World world = load_world(kWorlds / (GetParam() + ".yaml"));
  EXPECT_EQ(world.name, GetParam());
  EXPECT_TRUE(world.warnings.empty());
  EXPECT_FALSE(world.lighting.lamps_m.empty());
  const TruthMap map = truth_of(world);
  EXPECT_TRUE(map.closed);
  const Drive drive(world.route_m, world.limits, 240.0);
  ASSERT_GT(drive.lap_s(), 20.0) << "comes back to its start within four minutes";
  for (double t = 0.0; t < 2.0 * drive.lap_s(); t += 0.05) {
    const SE2 T = drive.T_world_base(t);
    ASSERT_GE(nearest_obstacle_m(map, {T.x, T.y}, 0.5), 0.25) << "at " << T.x << ", " << T.y;
  }
  std::set<int> classes(map.classes.begin(), map.classes.end());
  for (const ObstacleClass wanted :
       {ObstacleClass::kWall, ObstacleClass::kChair, ObstacleClass::kLowBox, ObstacleClass::kOther})
    EXPECT_EQ(classes.count(static_cast<int>(wanted)), 1U) << name_of(wanted);
}

INSTANTIATE_TEST_SUITE_P(Worlds, EveryWorld,
                         testing::Values("office", "corridor", "hall", "aliased_corridor"),
                         [](const auto& info) { return info.param; });

TEST(Worlds, AreAllTested) {
  std::size_t n = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kWorlds))
    n += entry.path().extension() == ".yaml";
  EXPECT_EQ(n, 4U) << "a new world belongs into EveryWorld above";
}

TEST(Worlds, CorridorIsFortyMetresRound) {
  const World world = load_world(kWorlds / "corridor.yaml");
  double length_m = 0.0;
  for (std::size_t i = 0; i < world.route_m.size(); ++i)
    length_m += (world.route_m[(i + 1) % world.route_m.size()] - world.route_m[i]).norm();
  EXPECT_NEAR(length_m, 40.0, 2.0);
}

// What a turn by 180 degrees about the middle leaves as it was can't be told apart by any sensor.
TEST(Worlds, AliasedCorridorLooksTheSameWhenTurned) {
  const World world = load_world(kWorlds / "aliased_corridor.yaml");
  const Eigen::Vector3d middle(9.3, 3.6, 0.0);
  int alone = 0;
  for (const Box& box : world.boxes) {
    Eigen::Vector3d turned = 2.0 * middle - box.T_world_box.translation();
    turned.z() = box.T_world_box.translation().z();
    const bool twin = std::any_of(world.boxes.begin(), world.boxes.end(), [&](const Box& other) {
      return (other.T_world_box.translation() - turned).norm() < 1e-6 &&
             (other.half_m - box.half_m).norm() < 1e-6 &&
             // Its x axis points the other way: the same face looks at who comes by.
             (other.T_world_box.linear().col(0) + box.T_world_box.linear().col(0))
                     .head<2>()
                     .norm() < 1e-6 &&
             other.material.kind == box.material.kind && other.material.bgr == box.material.bgr &&
             other.material.seed == box.material.seed;
    });
    alone += twin ? 0 : 1;
  }
  EXPECT_EQ(alone, 9);  // the boxes of the one chair, and the one picture
}

// Each wall is beyond the camera's range, at least one within the LiDAR's.
TEST(Worlds, HallIsLargerThanTheCameraSees) {
  const World world = load_world(kWorlds / "hall.yaml");
  const Drive drive(world.route_m, world.limits, 240.0);
  int n = 0, far = 0, lidar = 0;
  for (double t = 0.0; t < drive.lap_s(); t += 0.2, ++n) {
    const SE2 T = drive.T_world_base(t);
    double ahead_m = 1e3;  // along the optical axis, within the 58 degrees that the camera sees
    for (double angle = -0.51; angle <= 0.51; angle += 0.03) {
      const double c = std::cos(T.yaw + angle), s = std::sin(T.yaw + angle);
      const double x_m = c > 0 ? (24.0 - T.x) / c : (-2.0 - T.x) / std::min(c, -1e-9);
      const double y_m = s > 0 ? (22.0 - T.y) / s : (-2.0 - T.y) / std::min(s, -1e-9);
      ahead_m = std::min(ahead_m, std::min(x_m, y_m) * std::cos(angle));
    }
    far += ahead_m > 8.0;
    lidar += std::min({T.x + 2.0, 24.0 - T.x, T.y + 2.0, 22.0 - T.y}) < 12.0;
  }
  EXPECT_GT(far, 9 * n / 10);
  EXPECT_GT(lidar, 9 * n / 10);
}

}  // namespace
}  // namespace fusion_slam
