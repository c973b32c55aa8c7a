#include "drivers/simulator/camera_noise.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/simulator/random.hpp"

namespace fusion_slam {
namespace {

constexpr std::uint64_t kTableStream = 10;
constexpr std::uint64_t kFrameStream = 11;
constexpr std::size_t kTableSize = 1U << 16;

bool on_depth_edge(const cv::Mat_<float>& depth, int u, int v, double jump) {
  const float z = depth(v, u);
  const auto far_from = [&](int x, int y) {
    if (x < 0 || y < 0 || x >= depth.cols || y >= depth.rows) return false;
    return std::fabs(depth(y, x) - z) > jump * std::min(z, depth(y, x));
  };
  return far_from(u - 1, v) || far_from(u + 1, v) || far_from(u, v - 1) || far_from(u, v + 1);
}

}  // namespace

NoisyCamera::NoisyCamera(CameraModel camera, CameraNoise noise, std::uint64_t seed)
    : camera_(camera), noise_(noise), seed_(seed) {
  Random random(seed, kTableStream);
  for (std::size_t i = 0; i < kTableSize; ++i)
    gaussians_.push_back(static_cast<float>(random.gaussian()));
}

double NoisyCamera::measured_depth(double z_m, double gaussian) const {
  const double off = z_m - 0.4;
  const double sigma = noise_.depth_sigma_at_0_4_m + noise_.depth_sigma_per_m * off * off;
  const double noisy = std::max(0.1, z_m + sigma * gaussian);
  const double steps_m = camera_.fx_px * noise_.baseline_m / noise_.disparity_step_px;
  return steps_m / std::max(1.0, std::round(steps_m / noisy));
}

RgbdFrame NoisyCamera::expose(const RenderedFrame& ideal, std::int64_t index, std::int64_t utime_us,
                              bool noise) const {
  RgbdFrame frame;
  frame.utime_us = utime_us;
  frame.colour_bgr.create(ideal.depth_m.size(), CV_8UC3);
  frame.depth_mm.create(ideal.depth_m.size(), CV_16UC1);
  Random random(seed_, kFrameStream, static_cast<std::uint64_t>(index));
  const auto exposure = static_cast<float>(noise_.exposure);
  const auto sigma = static_cast<float>(noise ? noise_.colour_sigma : 0.0);
  for (int v = 0; v < ideal.depth_m.rows; ++v) {
    for (int u = 0; u < ideal.depth_m.cols; ++u) {
      const std::uint64_t bits = random.bits();  // four table places
      const auto gaussian = [&](int k) { return gaussians_[(bits >> (16 * k)) & 0xFFFFU]; };
      const cv::Vec3f& light = ideal.colour_bgr(v, u);
      auto& out = frame.colour_bgr.at<cv::Vec3b>(v, u);
      for (int k = 0; k < 3; ++k)
        out[k] = static_cast<std::uint8_t>(
            std::clamp(light[k] * exposure + sigma * gaussian(k) + 0.5F, 0.0F, 255.0F));
      double z = ideal.depth_m(v, u);
      if (noise && z > 0.0) {
        const bool edge = on_depth_edge(ideal.depth_m, u, v, noise_.edge_jump);
        const bool lost = ideal.cosine(v, u) < noise_.grazing_cosine ||
                          (edge && random.uniform() < noise_.edge_drop_fraction);
        z = lost ? 0.0 : measured_depth(z, gaussian(3));
      }
      frame.depth_mm.at<std::uint16_t>(v, u) =
          camera_.depth_valid(z) ? static_cast<std::uint16_t>(std::lround(1000.0 * z)) : 0;
    }
  }
  return frame;
}

}  // namespace fusion_slam
