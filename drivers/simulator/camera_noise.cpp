#include "drivers/simulator/camera_noise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/simulator/random.hpp"

namespace fusion_slam {
namespace {

constexpr std::uint64_t kTableStream = 10;
constexpr std::uint64_t kColourStream = 11;
constexpr std::uint64_t kDepthStream = 12;
constexpr std::uint64_t kPatchStream = 13;
constexpr std::size_t kTableSize = 1U << 16;
constexpr float kMidGrey = 128.0F;

// Bits of one pixel: a counter-based generator, since every pixel of 30 frames a second needs some.
std::uint64_t stream_base(std::uint64_t seed, std::uint64_t stream, std::int64_t index, int row) {
  const auto frame =
      mix_bits(mix_bits(mix_bits(seed) ^ stream) ^ static_cast<std::uint64_t>(index));
  return frame + (static_cast<std::uint64_t>(row) << 20);
}

float uniform_of(std::uint64_t bits) { return static_cast<float>(bits >> 40) * 0x1.0p-24F; }

bool on_depth_edge(const cv::Mat_<float>& depth, int u, int v, float jump) {
  const float z = depth(v, u);
  const auto far_from = [&](int x, int y) {
    if (x < 0 || y < 0 || x >= depth.cols || y >= depth.rows) return false;
    return std::fabs(depth(y, x) - z) > jump * std::min(z, depth(y, x));
  };
  return far_from(u - 1, v) || far_from(u + 1, v) || far_from(u, v - 1) || far_from(u, v + 1);
}

// Columns of a row that the projector, baseline to the right of the camera, does not light: some
// nearer thing to the right of them is in the way. pixels: f * baseline, so that a disparity is
// pixels / z.
void find_shadows(const float* depth, int n, float pixels, std::vector<std::uint8_t>* hidden) {
  constexpr float kSlackPx = 0.5F;  // a slanted wall is no obstacle to itself
  float leftmost = std::numeric_limits<float>::infinity();
  for (int u = n - 1; u >= 0; --u) {
    if (!(depth[u] > 0.0F)) {
      (*hidden)[static_cast<std::size_t>(u)] = 0;
      continue;
    }
    const float seen = static_cast<float>(u) - pixels / depth[u];  // column in the projector
    (*hidden)[static_cast<std::size_t>(u)] = seen > leftmost + kSlackPx ? 1 : 0;
    leftmost = std::min(leftmost, seen);
  }
}

}  // namespace

NoisyCamera::NoisyCamera(CameraModel camera, CameraNoise noise, std::uint64_t seed)
    : camera_(camera), noise_(noise), seed_(seed) {
  Random random(seed, kTableStream);
  for (std::size_t i = 0; i < kTableSize; ++i)
    gaussians_.push_back(static_cast<float>(random.gaussian()));
}

void NoisyCamera::colour_row(const cv::Mat_<cv::Vec3f>& light, int v, const Shot& shot,
                             cv::Mat* out) const {
  const auto gain = static_cast<float>(shot.exposure);
  const float sigma = noise_.with_colour_noise ? static_cast<float>(noise_.colour_sigma) : 0.0F;
  const float share = noise_.with_photon_noise ? static_cast<float>(noise_.photon_share) : 0.0F;
  const std::uint64_t base = stream_base(seed_, kColourStream, shot.index, v);
  auto* row = out->ptr<cv::Vec3b>(v);
  for (int u = 0; u < light.cols; ++u) {
    const std::uint64_t bits = mix_bits(base + static_cast<std::uint64_t>(u));
    for (int k = 0; k < 3; ++k) {
      const float grey = light(v, u)[k] * gain;
      const float s = sigma * std::sqrt(1.0F - share + share * grey / kMidGrey);
      row[u][k] = static_cast<std::uint8_t>(
          std::clamp(grey + s * gaussians_[(bits >> (16 * k)) & 0xFFFFU] + 0.5F, 0.0F, 255.0F));
    }
  }
}

// White noise on a coarse lattice, a node every correlation_px.
std::vector<float> NoisyCamera::patch_noise(std::int64_t index) const {
  const int pitch = noise_.correlation_px;
  const int across = camera_.width_px / pitch + 2, down = camera_.height_px / pitch + 2;
  std::vector<float> nodes;
  for (int y = 0; y < down; ++y) {
    const std::uint64_t base = stream_base(seed_, kPatchStream, index, y);
    for (int x = 0; x < across; ++x)
      nodes.push_back(gaussians_[mix_bits(base + static_cast<std::uint64_t>(x)) & 0xFFFFU]);
  }
  return nodes;
}

void NoisyCamera::depth_row(const RenderedFrame& ideal, const cv::Mat_<float>& depth, int v,
                            const Shot& shot, const std::vector<float>& patches,
                            cv::Mat* out) const {
  const int n = depth.cols;
  const auto pixels = static_cast<float>(camera_.fx_px * noise_.baseline_m);
  const float steps_m = pixels / static_cast<float>(noise_.disparity_step_px);
  std::vector<std::uint8_t> hidden(static_cast<std::size_t>(n), 0);
  if (noise_.with_depth_shadow) find_shadows(depth[v], n, pixels, &hidden);
  const std::uint64_t base = stream_base(seed_, kDepthStream, shot.index, v);
  const int pitch = noise_.correlation_px, across = camera_.width_px / pitch + 2;
  const float fv = static_cast<float>(v % pitch) / static_cast<float>(pitch);
  const int top_row = v / pitch * across;
  const float* top = patches.empty() ? nullptr : &patches[static_cast<std::size_t>(top_row)];
  const float common = std::sqrt(static_cast<float>(noise_.correlated_share));
  const float own = std::sqrt(1.0F - static_cast<float>(noise_.correlated_share));
  // Interpolation between nodes averages: divided by this, the noise has one sigma everywhere.
  const auto spread = [](float f) { return std::sqrt((1.0F - f) * (1.0F - f) + f * f); };
  const auto lost = [&](int u, float z, std::uint64_t bits) {
    if (hidden[static_cast<std::size_t>(u)] != 0) return true;
    if (noise_.with_depth_dropouts) {
      const float cosine = ideal.cosine(v, u);
      const cv::Vec3f& c = ideal.colour_bgr(v, u);
      const float reach = static_cast<float>(camera_.depth_max_m) / z;
      const float signal = (c[0] + c[1] + c[2]) / (3.0F * 255.0F) * cosine * reach * reach;
      if (cosine < static_cast<float>(noise_.grazing_cosine) ||
          signal < static_cast<float>(noise_.dark_signal))
        return true;
    }
    return noise_.with_depth_edges &&
           on_depth_edge(depth, u, v, static_cast<float>(noise_.edge_jump)) &&
           uniform_of(bits) < static_cast<float>(noise_.edge_drop_fraction);
  };
  auto* row = out->ptr<std::uint16_t>(v);
  for (int u = 0; u < n; ++u) {
    float z = depth(v, u);
    const std::uint64_t bits = mix_bits(base + static_cast<std::uint64_t>(u));
    if (z > 0.0F && lost(u, z, bits)) z = 0.0F;
    if (z > 0.0F && noise_.with_depth_noise) {
      float gaussian = gaussians_[bits & 0xFFFFU];
      if (!patches.empty()) {
        const float fu = static_cast<float>(u % pitch) / static_cast<float>(pitch);
        const float* node = top + u / pitch;
        const float a = node[0] + fu * (node[1] - node[0]);
        const float b = node[across] + fu * (node[across + 1] - node[across]);
        gaussian = own * gaussian + common * (a + fv * (b - a)) / (spread(fu) * spread(fv));
      }
      const float off = z - 0.4F;
      const float sigma = static_cast<float>(noise_.depth_sigma_at_0_4_m) +
                          static_cast<float>(noise_.depth_sigma_per_m) * off * off;
      z = std::max(0.1F, z + sigma * gaussian);
    }
    if (z > 0.0F && noise_.with_depth_steps)
      z = steps_m / std::max(1.0F, std::nearbyint(steps_m / z));
    const bool valid = camera_.depth_valid(static_cast<double>(z));
    row[u] = valid ? static_cast<std::uint16_t>(std::lrintf(1000.0F * z)) : 0;
  }
}

RgbdFrame NoisyCamera::expose(const RenderedFrame& ideal, const Shot& shot) const {
  ShutterModel shutter;
  if (noise_.with_motion_blur) shutter.open_s = noise_.shutter_s * shot.exposure;
  if (noise_.with_rolling_shutter) shutter.readout_s = noise_.rolling_readout_s;
  cv::Mat_<cv::Vec3f> light = ideal.colour_bgr;
  if (shutter.open_s > 0.0 || shutter.readout_s > 0.0)
    light = expose_moving(camera_, shot.twist, shutter, ideal.colour_bgr, ideal.depth_m);
  cv::Mat_<float> depth = ideal.depth_m;
  if (noise_.with_depth_delay)
    depth = depth_later(camera_, shot.twist, noise_.depth_delay_s, ideal.depth_m);
  std::vector<float> patches;
  if (noise_.with_depth_noise && noise_.with_depth_correlation) patches = patch_noise(shot.index);
  RgbdFrame frame;
  frame.utime_us = shot.utime_us;
  frame.colour_bgr.create(ideal.depth_m.size(), CV_8UC3);
  frame.depth_mm.create(ideal.depth_m.size(), CV_16UC1);
  for (int v = 0; v < ideal.depth_m.rows; ++v) {
    colour_row(light, v, shot, &frame.colour_bgr);
    depth_row(ideal, depth, v, shot, patches, &frame.depth_mm);
  }
  return frame;
}

RgbdFrame NoisyCamera::dark(const Shot& shot) const {
  const cv::Size size(camera_.width_px, camera_.height_px);
  RgbdFrame frame{shot.utime_us, cv::Mat(size, CV_8UC3), cv::Mat::zeros(size, CV_16UC1)};
  const cv::Mat_<cv::Vec3f> black(size, cv::Vec3f(0, 0, 0));
  for (int v = 0; v < size.height; ++v) colour_row(black, v, shot, &frame.colour_bgr);
  return frame;
}

double mean_grey(const RenderedFrame& frame) {
  double sum = 0.0;
  int n = 0;
  for (int v = 4; v < frame.colour_bgr.rows; v += 8)
    for (int u = 4; u < frame.colour_bgr.cols; u += 8) {
      const cv::Vec3f& c = frame.colour_bgr(v, u);
      sum += static_cast<double>(c[0] + c[1] + c[2]) / 3.0;
      ++n;
    }
  return n > 0 ? sum / n : 0.0;
}

}  // namespace fusion_slam
