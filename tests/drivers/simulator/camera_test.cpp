#include <cmath>

#include <gtest/gtest.h>

#include "drivers/simulator/camera_noise.hpp"
#include "drivers/simulator/recording.hpp"

namespace fusion_slam {
namespace {

World office() { return load_world(std::string(FS_SOURCE_DIR) + "/config/worlds/office.yaml"); }

RenderedFrame flat(double z_m) {
  return {cv::Mat_<cv::Vec3f>(480, 640, cv::Vec3f(100, 100, 100)),
          cv::Mat_<float>(480, 640, static_cast<float>(z_m)), cv::Mat_<std::int32_t>(480, 640, 0),
          cv::Mat_<float>(480, 640, 1.0F)};
}

// The tiles of the image hold, in order, all that a ray could meet.
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
        ASSERT_NEAR(frame.depth_m(v, u), hit->t, 1e-5) << u << ", " << v;
      }
  }
}

TEST(NoisyCamera, DepthNoiseIsTheModels) {
  const NoisyCamera noisy(simulated_camera(15), CameraNoise{}, 5);
  for (const double z : {1.0, 2.0, 4.0}) {
    const RgbdFrame frame = noisy.expose(flat(z), 3, 0, true);
    double sum = 0, squares = 0;
    const double n = 640.0 * 480.0;
    for (int v = 0; v < 480; ++v)
      for (int u = 0; u < 640; ++u) {
        const double error = frame.depth_mm.at<std::uint16_t>(v, u) / 1000.0 - z;
        sum += error;
        squares += error * error;
      }
    const double sigma = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
    const double step = z * z / (570.0 * 0.075) / 8.0;  // of depth, for an eighth of a pixel
    EXPECT_NEAR(sum / n, 0.0, 0.25 * step) << z;
    EXPECT_NEAR(std::sqrt(squares / n), std::sqrt(sigma * sigma + step * step / 12.0), 0.12 * sigma)
        << z;
  }
}

TEST(NoisyCamera, RangeLimitsAndEdgesAndColour) {
  const NoisyCamera noisy(simulated_camera(15), CameraNoise{}, 5);
  EXPECT_EQ(cv::countNonZero(noisy.expose(flat(0.5), 0, 0, false).depth_mm), 0);
  EXPECT_EQ(cv::countNonZero(noisy.expose(flat(8.5), 0, 0, false).depth_mm), 0);
  RenderedFrame step = flat(1.0);
  step.depth_m.colRange(320, 640) = 2.0F;
  const RgbdFrame frame = noisy.expose(step, 0, 0, true);
  const int kept = cv::countNonZero(frame.depth_mm.colRange(319, 321));
  EXPECT_NEAR(kept / 960.0, 0.3, 0.06);
  EXPECT_EQ(cv::countNonZero(frame.depth_mm.colRange(0, 319)), 319 * 480);
  cv::Scalar mean, deviation;
  cv::meanStdDev(frame.colour_bgr, mean, deviation);
  EXPECT_NEAR(mean[0], 105.0, 0.1);
  EXPECT_NEAR(deviation[0], 2.5, 0.1);
}

}  // namespace
}  // namespace fusion_slam
