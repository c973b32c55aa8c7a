#include "services/dense_mapper/mounting.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "libs/grid/cell_state.hpp"
#include "services/dense_mapper/dense_mapper.hpp"
#include "tests/services/dense_mapper/synthetic_room.hpp"

namespace fusion_slam {
namespace {

SE3 mounted(double pitch_deg, double roll_deg, double z_m) {
  SE3 T = from_xyz_rpy(0.1, 0.0, z_m, roll_deg * M_PI / 180, pitch_deg * M_PI / 180, 0.0);
  T.linear() = T.linear() * optical_to_body();
  return T;
}

CameraModel fine_camera() {
  CameraModel camera = small_camera();
  camera.width_px *= 4;
  camera.height_px *= 4;
  camera.fx_px *= 4;
  camera.fy_px *= 4;
  camera.cx_px = 4 * camera.cx_px + 1.5;
  camera.cy_px = 4 * camera.cy_px + 1.5;
  return camera;
}

// What the camera sees mounted as `is`, in a room of which it is thought to be mounted as
// `believed`.
DepthCloud seen(const SE3& T_room_base, const SE3& is) {
  const CameraModel camera = fine_camera();
  return make_depth_cloud(render_room(T_room_base * is, camera, 1), camera, 0.05,
                          DenseMapperConfig{});
}

TEST(Mounting, FloorIsFoundAsItIs) {
  const SE3 is = mounted(0, 0, 0.35);
  const auto level = fit_floor(seen(SE3::Identity(), is).surfaces, is);
  ASSERT_TRUE(level);
  EXPECT_NEAR(level->slope_x, 0.0, 0.003);
  EXPECT_NEAR(level->height_m, 0.0, 0.005);
  // Believed level, but looking down by a degree: the floor seems to rise.
  const auto tilted = fit_floor(seen(SE3::Identity(), mounted(1, 0, 0.35)).surfaces, is);
  ASSERT_TRUE(tilted);
  EXPECT_NEAR(tilted->slope_x, std::tan(M_PI / 180), 0.004);
}

TEST(Mounting, CorrectionLevelsTheFloor) {
  const FloorPlane floor{0.02, -0.01, 0.015};
  const SE3 T = levelled_floor(floor);
  for (const double x : {0.0, 1.0, 5.0})
    for (const double y : {-2.0, 0.0, 2.0}) {
      const double z = floor.slope_x * x + floor.slope_y * y + floor.height_m;
      EXPECT_NEAR((T * Eigen::Vector3d(x, y, z)).z(), 0.0, 1e-9);
    }
}

TEST(Mounting, WithoutAFloorNothingIsCorrected) {
  DepthCloud wall;
  for (int i = 0; i < 500; ++i)
    wall.surfaces.push_back({{0.01F * static_cast<float>(i % 50), 0.0F, 2.0F}, {0, 0, -1}});
  Mounting mounting;
  mounting.add(wall, mounted(0, 0, 0.35));
  EXPECT_EQ(mounting.floors(), 0U);
  EXPECT_TRUE(mounting.correction().isApprox(SE3::Identity()));
}

// Occupied cells of the open floor between robot and box, and cells of the wall, with a mounting
// that is off by a degree.
TEST(Mounting, ADegreeMakesNoGhosts) {
  for (const auto& [pitch, roll] :
       {std::pair(1.0, 0.0), std::pair(-1.0, 0.0), std::pair(1.0, 1.0)}) {
    RobotModel robot;
    robot.T_base_camera = mounted(0, 0, 0.35);
    const SE3 is = mounted(pitch, roll, 0.35);
    const CameraModel camera = fine_camera();
    DenseMapper mapper(camera, robot, DenseMapperConfig{});
    for (int id = 1; id <= 8; ++id) {
      const SE3 T = to_se3(SE2{-1.6 + 0.1 * id, 0.1 * (id % 3), 0.2 * (id % 3 - 1)});
      mapper.add_keyframe(id, render_room(T * is, camera, id));
      mapper.set_pose(id, T, id);
    }
    mapper.integrate_ready();
    int ghosts = 0, wall = 0;
    for (const Tile& tile : mapper.update(true).grid) {
      const auto cells = decode_grid_tile(tile);
      if (!cells) continue;
      for (int i = 0; i < kTileCells * kTileCells; ++i) {
        const double x = (tile.key.x * kTileCells + i % kTileCells + 0.5) * 0.05;
        const double y = (tile.key.y * kTileCells + i / kTileCells + 0.5) * 0.05;
        if (state_of_cell((*cells)[static_cast<std::size_t>(i)]) != CellState::kOccupied) continue;
        const bool box = x > 1.35 && x < 1.95 && std::abs(y) < 0.35;
        if (x < 2.35 && !box) ++ghosts;
        if (x > 2.35) ++wall;
      }
    }
    EXPECT_EQ(ghosts, 0) << pitch << " " << roll;
    EXPECT_GT(wall, 20) << pitch << " " << roll;
    const double corrected = log_so3(mapper.mounting_correction().linear()).norm() * 180 / M_PI;
    EXPECT_NEAR(corrected, std::hypot(pitch, roll), 0.3);
  }
}

}  // namespace
}  // namespace fusion_slam
