#include <cmath>

#include <gtest/gtest.h>

#include "drivers/simulator/simulation.hpp"

namespace fusion_slam {
namespace {

World office() { return load_world(std::string(FS_SOURCE_DIR) + "/config/worlds/office.yaml"); }

// The tiles of the image hold, in order, all that a ray could meet.
TEST(CameraRenderer, DepthIsWhatSingleRaysFind) {
  const World world = office();
  const Scene scene(world.boxes);
  const CameraModel camera = simulated_camera(15);
  const CameraRenderer renderer(scene, world.lighting, camera, false);
  int different = 0;  // a ray along an edge may pass on either side
  for (const double yaw : {0.0, 1.0, 2.5, 4.0}) {
    const SE3 T_world_camera =
        from_xyz_rpy(2.0, 1.1, 0.0, 0.0, 0.0, yaw) * simulated_robot().T_base_camera;
    const RenderedFrame frame = renderer.render(T_world_camera);
    for (int v = 3; v < 480; v += 7)
      for (int u = 2; u < 640; u += 5) {
        const auto hit = scene.cast(T_world_camera.translation(),
                                    T_world_camera.linear() * camera.unproject(u, v, 1.0));
        ASSERT_TRUE(hit);
        if (std::fabs(frame.depth_m(v, u) - hit->t) > 1e-5) ++different;
      }
  }
  EXPECT_LT(different, 4);
}

}  // namespace
}  // namespace fusion_slam
