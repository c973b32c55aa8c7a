#include <cmath>

#include <gtest/gtest.h>

#include "drivers/simulator/simulation.hpp"

namespace fusion_slam {
namespace {

World office() { return load_world(std::string(FS_SOURCE_DIR) + "/config/worlds/office.yaml"); }

// A ray exactly along an edge may pass on either side: then one a thousandth of a pixel beside it
// has to find that depth.
bool beside_finds(const Scene& scene, const SE3& T_world_camera, const CameraModel& camera, int u,
                  int v, float depth_m) {
  for (const double du : {-1e-3, 1e-3})
    for (const double dv : {-1e-3, 1e-3}) {
      const auto hit = scene.cast(T_world_camera.translation(),
                                  T_world_camera.linear() * camera.unproject(u + du, v + dv, 1.0));
      if (hit && std::fabs(depth_m - hit->t) < 1e-3) return true;
    }
  return false;
}

// Every pixel is what a single ray through it meets.
TEST(CameraRenderer, DepthIsWhatSingleRaysFind) {
  const World world = office();
  const Scene scene(world.boxes);
  const CameraModel camera = simulated_camera(15);
  const CameraRenderer renderer(scene, world.lighting, camera, false);
  for (const double yaw : {0.0, 1.0, 2.5, 4.0}) {
    const SE3 T_world_camera =
        from_xyz_rpy(2.0, 1.1, 0.0, 0.0, 0.0, yaw) * simulated_robot().T_base_camera;
    const RenderedFrame frame = renderer.render(T_world_camera);
    for (int v = 3; v < 480; v += 7)
      for (int u = 2; u < 640; u += 5) {
        const auto hit = scene.cast(T_world_camera.translation(),
                                    T_world_camera.linear() * camera.unproject(u, v, 1.0));
        ASSERT_TRUE(hit);
        if (std::fabs(frame.depth_m(v, u) - hit->t) > 1e-5) {
          ASSERT_TRUE(beside_finds(scene, T_world_camera, camera, u, v, frame.depth_m(v, u)))
              << u << ", " << v << ": " << frame.depth_m(v, u) << " instead of " << hit->t;
        }
      }
  }
}

}  // namespace
}  // namespace fusion_slam
