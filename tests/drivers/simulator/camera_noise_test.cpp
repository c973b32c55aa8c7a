// The statistics that docs/simulator.md quotes: measured here from many samples against the models'
// sources.
#include "drivers/simulator/camera_noise.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "drivers/simulator/sensor_noise.hpp"

namespace fusion_slam {
namespace {

CameraModel astra() {
  CameraModel camera;
  camera.fx_px = camera.fy_px = 570.0;
  camera.depth_min_m = 0.6;
  camera.depth_max_m = 8.0;
  return camera;
}

RenderedFrame flat(double z_m, float grey = 100.0F, float cosine = 1.0F) {
  return {cv::Mat_<cv::Vec3f>(480, 640, cv::Vec3f(grey, grey, grey)),
          cv::Mat_<float>(480, 640, static_cast<float>(z_m)), cv::Mat_<std::int32_t>(480, 640, 0),
          cv::Mat_<float>(480, 640, cosine)};
}

// A camera with the effects of this list only.
NoisyCamera camera_with(const std::vector<std::string>& names) {
  SensorNoise noise;
  set_effect("all", false, &noise);
  for (const auto& name : names) set_effect(name, true, &noise);
  return NoisyCamera(astra(), noise.camera, 5);
}

Shot shot(std::int64_t index = 3) {
  Shot s;
  s.index = index;
  return s;
}

struct Errors {
  double mean = 0.0, sigma = 0.0, next = 0.0;  // next: correlation with the pixel to the right
};
Errors depth_errors(const RgbdFrame& frame, double z_m) {
  double sum = 0, squares = 0, products = 0;
  int n = 0;
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u + 1 < 640; ++u, ++n) {
      const double e = frame.depth_mm.at<std::uint16_t>(v, u) / 1000.0 - z_m;
      const double f = frame.depth_mm.at<std::uint16_t>(v, u + 1) / 1000.0 - z_m;
      sum += e;
      squares += e * e;
      products += e * f;
    }
  return {sum / n, std::sqrt(squares / n), products / squares};
}

TEST(NoisyCamera, DepthNoiseIsTheModels) {
  const NoisyCamera white = camera_with({"depth-noise", "depth-steps"});
  const NoisyCamera patchy = camera_with({"depth-noise", "depth-steps", "depth-correlation"});
  for (const double z : {1.0, 2.0, 4.0}) {
    const double sigma = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
    const double step = z * z / (570.0 * 0.075) / 8.0;  // of depth, for an eighth of a pixel
    const double expected = std::sqrt(sigma * sigma + step * step / 12.0);
    const Errors a = depth_errors(white.expose(flat(z), shot()), z);
    EXPECT_NEAR(a.mean, 0.0, 0.25 * step) << z;
    EXPECT_NEAR(a.sigma, expected, 0.12 * sigma) << z;
    EXPECT_LT(a.next, 0.25) << z;  // steps alone make neighbours a little alike
    const Errors b = depth_errors(patchy.expose(flat(z), shot()), z);
    EXPECT_NEAR(b.mean, 0.0, 0.25 * step) << z;
    EXPECT_NEAR(b.sigma, expected, 0.12 * sigma) << z;
    EXPECT_GT(b.next, a.next + 0.2) << z;
    std::printf(
        "depth noise at %.0f m: source %.4f m, with steps %.4f m; measured %.4f m, "
        "correlated %.4f m\n",
        z, sigma, expected, a.sigma, b.sigma);
  }
}

TEST(NoisyCamera, StepsAreEighthsOfAPixelOfDisparity) {
  const RgbdFrame frame = camera_with({"depth-steps"}).expose(flat(4.01), shot());
  const double disparity = 570.0 * 0.075 / (frame.depth_mm.at<std::uint16_t>(1, 1) / 1000.0);
  EXPECT_NEAR(disparity * 8.0, std::round(disparity * 8.0), 0.01);
}

TEST(NoisyCamera, RangeLimitsAndEdges) {
  const NoisyCamera ideal = camera_with({});
  EXPECT_EQ(cv::countNonZero(ideal.expose(flat(0.5), shot()).depth_mm), 0);
  EXPECT_EQ(cv::countNonZero(ideal.expose(flat(8.5), shot()).depth_mm), 0);
  EXPECT_EQ(ideal.expose(flat(2.345), shot()).depth_mm.at<std::uint16_t>(9, 9), 2345);
  RenderedFrame step = flat(1.0);
  step.depth_m.colRange(320, 640) = 2.0F;
  const RgbdFrame frame = camera_with({"depth-edges"}).expose(step, shot());
  EXPECT_NEAR(cv::countNonZero(frame.depth_mm.colRange(319, 321)) / 960.0, 0.3, 0.06);
  EXPECT_EQ(cv::countNonZero(frame.depth_mm.colRange(0, 319)), 319 * 480);
}

// A board before a wall: to its left the wall is in the projector's shadow, as wide as the two
// disparities differ.
TEST(NoisyCamera, ProjectorShadowIsAsWideAsTheDisparitiesDiffer) {
  RenderedFrame board = flat(4.0);
  board.depth_m.colRange(300, 400) = 1.0F;
  const RgbdFrame frame = camera_with({"depth-shadow"}).expose(board, shot());
  const double width = 570.0 * 0.075 * (1.0 / 1.0 - 1.0 / 4.0);
  const int lost = 640 - cv::countNonZero(frame.depth_mm.row(7));
  EXPECT_NEAR(lost, width, 2.0);
  EXPECT_EQ(frame.depth_mm.at<std::uint16_t>(7, 299), 0);
  EXPECT_NE(frame.depth_mm.at<std::uint16_t>(7, 300), 0);
  EXPECT_NE(frame.depth_mm.at<std::uint16_t>(7, 401), 0);
}

TEST(NoisyCamera, GlancingAndDarkSurfacesGiveNoDepth) {
  const NoisyCamera camera = camera_with({"depth-dropouts"});
  EXPECT_EQ(cv::countNonZero(camera.expose(flat(2.0, 100, 0.1F), shot()).depth_mm), 0);
  EXPECT_GT(cv::countNonZero(camera.expose(flat(2.0, 100, 0.2F), shot()).depth_mm), 0);
  EXPECT_EQ(cv::countNonZero(camera.expose(flat(7.0, 15, 1.0F), shot()).depth_mm), 0);
  EXPECT_GT(cv::countNonZero(camera.expose(flat(3.0, 15, 1.0F), shot()).depth_mm), 0);
}

TEST(NoisyCamera, ColourNoiseGrowsWithTheLight) {
  const auto sigma_at = [](const NoisyCamera& camera, float grey) {
    cv::Scalar mean, sigma;
    cv::meanStdDev(camera.expose(flat(2.0, grey), shot()).colour_bgr, mean, sigma);
    EXPECT_NEAR(mean[1], grey, 0.1);
    return sigma[1];
  };
  const NoisyCamera even = camera_with({"colour-noise"});
  EXPECT_NEAR(sigma_at(even, 40), 2.5, 0.1);
  EXPECT_NEAR(sigma_at(even, 200), 2.5, 0.1);
  const NoisyCamera photons = camera_with({"colour-noise", "photon-noise"});
  EXPECT_NEAR(sigma_at(photons, 128), 2.5, 0.1);
  EXPECT_NEAR(sigma_at(photons, 32), 2.5 * std::sqrt(0.4 + 0.6 / 4), 0.1);
}

TEST(NoisyCamera, EqualSeedsAndFramesGiveEqualImages) {
  const NoisyCamera camera(astra(), CameraNoise{}, 9);
  Shot moving = shot();
  moving.twist.angular_rad_s = Eigen::Vector3d(0.0, 0.5, 0.0);
  const RgbdFrame a = camera.expose(flat(2.0), moving), b = camera.expose(flat(2.0), moving);
  EXPECT_EQ(cv::norm(a.depth_mm, b.depth_mm, cv::NORM_L1), 0.0);
  EXPECT_EQ(cv::norm(a.colour_bgr, b.colour_bgr, cv::NORM_L1), 0.0);
  moving.index = 4;
  EXPECT_GT(cv::norm(a.depth_mm, camera.expose(flat(2.0), moving).depth_mm, cv::NORM_L1), 0.0);
  const RgbdFrame covered = camera.dark(shot());
  EXPECT_EQ(cv::countNonZero(covered.depth_mm), 0);
  EXPECT_LT(cv::mean(covered.colour_bgr)[0], 3.0);
}

TEST(SensorNoise, EveryEffectAndParameterHasAName) {
  SensorNoise noise;
  for (const Effect& e : effects()) {
    EXPECT_EQ(effect_is_on(e.name, noise), e.on_by_default) << e.name;
    set_effect(e.name, !e.on_by_default, &noise);
    EXPECT_NE(effect_is_on(e.name, noise), e.on_by_default) << e.name;
  }
  set_effect("all", false, &noise);
  for (const Effect& e : effects()) EXPECT_FALSE(effect_is_on(e.name, noise)) << e.name;
  set_parameter("slip_sigma_per_sqrt_m", 0.02, &noise);
  EXPECT_EQ(noise.wheels.slip_sigma_per_sqrt_m, 0.02);
  EXPECT_THROW(set_parameter("slip_sigma", 0.02, &noise), std::invalid_argument);
  EXPECT_THROW(set_parameter("colour_sigma", -1.0, &noise), std::invalid_argument);
  try {
    set_effect("motionblur", false, &noise);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("'motion-blur'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace fusion_slam
