#include <cmath>

#include <gtest/gtest.h>

#include "drivers/simulator/camera_renderer.hpp"
#include "drivers/simulator/furniture.hpp"
#include "drivers/simulator/lidar_sensor.hpp"
#include "drivers/simulator/simulation.hpp"

namespace fusion_slam {
namespace {

// Inside of a room from (0, 0) to (5, 4).
Scene room() {
  const Material m;
  return Scene({standing_box({-0.1, 2, 0}, 0, {0.2, 4.4, 2}, m),
                standing_box({5.1, 2, 0}, 0, {0.2, 4.4, 2}, m),
                standing_box({2.5, -0.1, 0}, 0, {5.4, 0.2, 2}, m),
                standing_box({2.5, 4.1, 0}, 0, {5.4, 0.2, 2}, m)});
}

double wall_distance(double x, double y, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const double along_x = c > 0 ? (5 - x) / c : -x / c;
  const double along_y = s > 0 ? (4 - y) / s : -y / s;
  return std::min(along_x, along_y);
}

// Drives straight and turns while the device does.
SE2 moving(double time_s) { return {1.5 + 0.5 * time_s, 1.2, 0.4 + 0.9 * time_s}; }

TEST(LidarSensor, IdealBeamsAreWallDistancesFromWhereTheRobotIs) {
  const RobotModel robot = simulated_robot();
  const LaserScan scan = sweep(room(), robot, LidarNoise{}, moving, 0, 1, 0, false);
  ASSERT_EQ(scan.ranges_m.size(), 360U);
  for (int i = 0; i < 360; ++i) {
    const SE2 at = moving(i * robot.lidar.beam_period_s);
    const double angle = at.yaw + scan.rad0 + i * scan.radstep;
    EXPECT_NEAR(scan.ranges_m[static_cast<std::size_t>(i)], wall_distance(at.x, at.y, angle), 1e-5);
  }
  EXPECT_NEAR(360 * robot.lidar.beam_period_s, 1.0 / 7.0, 1e-12);
}

TEST(LidarSensor, NoiseIsOnePercentAndGlancingBeamsAreLost) {
  const RobotModel robot = simulated_robot();
  const auto still = [](double) { return SE2{0.12, 2.0, 0.0}; };  // close to a long wall
  const Scene scene = room();
  const LaserScan ideal = sweep(scene, robot, LidarNoise{}, still, 0, 1, 0, false);
  double squares = 0;
  int n = 0, lost = 0;
  for (int index = 0; index < 50; ++index) {
    const LaserScan scan = sweep(scene, robot, LidarNoise{}, still, 0, 1, index, true);
    for (std::size_t i = 0; i < 360; ++i) {
      if (ideal.ranges_m[i] < 0.2F) continue;  // noise could take it below the shortest range
      if (scan.ranges_m[i] == 0.0F) {
        ++lost;
        continue;
      }
      const double error = scan.ranges_m[i] / ideal.ranges_m[i] - 1.0;
      squares += error * error;
      ++n;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / n), 0.01, 0.0004);
  EXPECT_GT(lost, 50);
  EXPECT_LT(lost, n / 10);
}

TEST(LidarSensor, SeesTheWorldPointThatTheCameraSees) {
  const World world = load_world(std::string(FS_SOURCE_DIR) + "/config/worlds/office.yaml");
  const Scene scene(world.boxes);
  const RobotModel robot = simulated_robot();
  const CameraModel camera = simulated_camera(15);
  const auto still = [](double) { return SE2{2.0, 1.0, 0.3}; };
  const SE3 T_world_base = to_se3(still(0.0));
  const LaserScan scan = sweep(scene, robot, LidarNoise{}, still, 0, 1, 0, false);
  const RenderedFrame frame = CameraRenderer(scene, world.lighting, camera, false)
                                  .render(T_world_base * robot.T_base_camera);
  int both = 0;
  for (int i = 0; i < 360; ++i) {
    const double range = scan.ranges_m[static_cast<std::size_t>(i)];
    const double angle = scan.rad0 + i * scan.radstep;
    const Eigen::Vector3d p_base =
        robot.T_base_lidar * Eigen::Vector3d(range * std::cos(angle), range * std::sin(angle), 0);
    const Eigen::Vector3d p_camera = robot.T_base_camera.inverse() * p_base;
    if (range == 0.0 || p_camera.z() < 0.3) continue;
    const Eigen::Vector2d uv = camera.project(p_camera);
    const int u = static_cast<int>(std::lround(uv.x())), v = static_cast<int>(std::lround(uv.y()));
    if (u < 1 || v < 1 || u > 638 || v > 478) continue;
    if (frame.surface(v, u) != frame.surface(v, u - 1) ||
        frame.surface(v, u) != frame.surface(v, u + 1) || frame.depth_m(v, u) < p_camera.z() - 0.1)
      continue;  // an edge, or hidden from the camera, which sits 0.1 m further ahead
    const Eigen::Vector3d seen = camera.unproject(u, v, frame.depth_m(v, u));
    // Within a pixel's footprint on a slanted wall.
    EXPECT_LT((seen - p_camera).norm(), 0.012 * p_camera.z()) << i;
    ++both;
  }
  EXPECT_GT(both, 35);
}

}  // namespace
}  // namespace fusion_slam
