#include "drivers/simulator/surface.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/simulator/texture.hpp"

namespace fusion_slam {
namespace {

constexpr double kTexelM = 0.003;          // a camera pixel covers 1.75 mm at 1 m
constexpr double kPictureTexelM = 0.0015;  // posters, paper, screens: fine print
constexpr double kLightStepM = 0.08;       // lattice on which shadows are computed
constexpr double kLiftM = 0.004;           // shadow rays start this far above the surface
constexpr float kWhite = 235.0F;           // grey value of full reflectance in unit light
constexpr double kMaxTexels = 6e6;

bool fine(TextureKind kind) {
  return kind == TextureKind::kPoster || kind == TextureKind::kPaper ||
         kind == TextureKind::kScreen;
}

double light_at(const Scene& scene, const Lighting& lighting, const Eigen::Vector3d& p,
                const Eigen::Vector3d& normal) {
  double light = lighting.ambient * (1.0 + 0.15 * normal.x() + 0.1 * normal.y());
  for (const Eigen::Vector3d& lamp : lighting.lamps_m) {
    const Eigen::Vector3d to_lamp = lamp - p;
    const double cosine = normal.dot(to_lamp.normalized());
    if (cosine <= 0.0 || scene.cast(p, to_lamp, 1.0)) continue;
    light += lighting.lamp_power * cosine / (1.0 + to_lamp.squaredNorm());
  }
  return light;
}

}  // namespace

FaceAxes face_axes(const Box& box, int face) {
  const Eigen::Vector3d normal = face_normal(face);
  FaceAxes axes;
  const bool horizontal = face / 2 == 2;
  axes.s = horizontal ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ().cross(normal);
  axes.t = -normal.cross(axes.s);  // down: right-handed with s and the viewing direction
  axes.corner = box.half_m.cwiseProduct(normal - axes.s - axes.t);
  axes.width_m = 2.0 * box.half_m.dot(axes.s.cwiseAbs());
  axes.height_m = 2.0 * box.half_m.dot(axes.t.cwiseAbs());
  return axes;
}

Surface::Surface(const Scene& scene, const Lighting& lighting, int box_index, int face) {
  const Box& box = scene.boxes()[static_cast<std::size_t>(box_index)];
  const FaceAxes axes = face_axes(box, face);
  const Texture texture(box.material, face, axes.width_m, axes.height_m);
  const double area = axes.width_m * axes.height_m;
  const double texel =
      std::max(fine(box.material.kind) ? kPictureTexelM : kTexelM, std::sqrt(area / kMaxTexels));
  Level level;
  level.width = std::max(1, static_cast<int>(std::ceil(axes.width_m / texel)));
  level.height = std::max(1, static_cast<int>(std::ceil(axes.height_m / texel)));
  const double step_s = axes.width_m / level.width, step_t = axes.height_m / level.height;
  texels_per_m_s_ = static_cast<float>(1.0 / step_s);
  texels_per_m_t_ = static_cast<float>(1.0 / step_t);

  const int n_s = static_cast<int>(axes.width_m / kLightStepM) + 1;
  const int n_t = static_cast<int>(axes.height_m / kLightStepM) + 1;
  std::vector<float> light;
  const Eigen::Vector3d normal = box.T_world_box.linear() * face_normal(face);
  for (int j = 0; j <= n_t; ++j) {
    for (int i = 0; i <= n_s; ++i) {
      const Eigen::Vector3d p =
          axes.corner + axes.s * (axes.width_m * i / n_s) + axes.t * (axes.height_m * j / n_t);
      const Eigen::Vector3d lifted = box.T_world_box * p + kLiftM * normal;
      light.push_back(static_cast<float>(light_at(scene, lighting, lifted, normal)));
    }
  }
  level.texels.resize(static_cast<std::size_t>(level.width) * level.height);
  for (int y = 0; y < level.height; ++y) {
    const float v = (y + 0.5F) / level.height * n_t;
    const int j = std::min(static_cast<int>(v), n_t - 1);
    for (int x = 0; x < level.width; ++x) {
      const float u = (x + 0.5F) / level.width * n_s;
      const int i = std::min(static_cast<int>(u), n_s - 1);
      const float* row = &light[static_cast<std::size_t>(j) * (n_s + 1) + i];
      const float* next = row + n_s + 1;
      const float a = u - i, b = v - j;
      const float lit =
          (row[0] * (1 - a) + row[1] * a) * (1 - b) + (next[0] * (1 - a) + next[1] * a) * b;
      const Colour c = texture.at((x + 0.5F) * static_cast<float>(step_s),
                                  (y + 0.5F) * static_cast<float>(step_t));
      auto& texel_out = level.texels[static_cast<std::size_t>(y) * level.width + x];
      for (std::size_t k = 0; k < 3; ++k)
        texel_out[k] = static_cast<std::uint8_t>(std::clamp(c[k] * lit * kWhite, 0.0F, 255.0F));
    }
  }
  levels_.push_back(std::move(level));
  while (levels_.back().width > 1 || levels_.back().height > 1)
    levels_.push_back(half_size(levels_.back()));
}

Surface::Level Surface::half_size(const Level& level) {
  Level half;
  half.width = (level.width + 1) / 2;
  half.height = (level.height + 1) / 2;
  half.texels.resize(static_cast<std::size_t>(half.width) * half.height);
  const auto in = [&](int x, int y) {
    return level.texels[static_cast<std::size_t>(std::min(y, level.height - 1)) * level.width +
                        std::min(x, level.width - 1)];
  };
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x)
      for (std::size_t k = 0; k < 3; ++k)
        half.texels[static_cast<std::size_t>(y) * half.width + x][k] =
            static_cast<std::uint8_t>((in(2 * x, 2 * y)[k] + in(2 * x + 1, 2 * y)[k] +
                                       in(2 * x, 2 * y + 1)[k] + in(2 * x + 1, 2 * y + 1)[k] + 2) /
                                      4);
  return half;
}

void Surface::add_bilinear(std::size_t level, float s_m, float t_m, float weight,
                           float* bgr) const {
  const Level& l = levels_[level];
  const float shrink = 1.0F / static_cast<float>(1U << level);
  const float x = std::clamp(s_m * texels_per_m_s_ * shrink - 0.5F, 0.0F, l.width - 1.0F);
  const float y = std::clamp(t_m * texels_per_m_t_ * shrink - 0.5F, 0.0F, l.height - 1.0F);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int right = x0 + 1 < l.width ? 1 : 0, below = y0 + 1 < l.height ? l.width : 0;
  const float a = x - x0, b = y - y0;
  const auto* p = &l.texels[static_cast<std::size_t>(y0) * l.width + x0];
  const float w00 = weight * (1 - a) * (1 - b), w10 = weight * a * (1 - b);
  const float w01 = weight * (1 - a) * b, w11 = weight * a * b;
  for (std::size_t k = 0; k < 3; ++k)
    bgr[k] += w00 * p[0][k] + w10 * p[right][k] + w01 * p[below][k] + w11 * p[below + right][k];
}

std::array<float, 3> Surface::at(float s_m, float t_m, float footprint_m) const {
  std::array<float, 3> bgr{};
  const float texels = footprint_m * texels_per_m_s_;
  // log2 that is linear between powers of two: blending hides the difference.
  int exponent = 0;
  const float mantissa = std::frexp(std::max(texels, 1.0F), &exponent);
  const auto last = static_cast<float>(levels_.size() - 1);
  const float level = std::min(static_cast<float>(exponent - 1) + 2.0F * mantissa - 1.0F, last);
  const auto lower = static_cast<std::size_t>(level);
  const float blend = level - static_cast<float>(lower);
  add_bilinear(lower, s_m, t_m, 1.0F - blend, bgr.data());
  if (blend > 0.0F) add_bilinear(lower + 1, s_m, t_m, blend, bgr.data());
  return bgr;
}

}  // namespace fusion_slam
