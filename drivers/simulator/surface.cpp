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
constexpr double kMaxTexels = 6e6;

bool fine(TextureKind kind) {
  return kind == TextureKind::kPoster || kind == TextureKind::kPaper ||
         kind == TextureKind::kScreen;
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
  const int width = std::max(1, static_cast<int>(std::ceil(axes.width_m / texel)));
  const int height = std::max(1, static_cast<int>(std::ceil(axes.height_m / texel)));
  const double step_s = axes.width_m / width, step_t = axes.height_m / height;
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
  std::vector<Texel> texels;
  texels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    const float v = (static_cast<float>(y) + 0.5F) / static_cast<float>(height) * n_t;
    const int j = std::min(static_cast<int>(v), n_t - 1);
    for (int x = 0; x < width; ++x) {
      const float u = (static_cast<float>(x) + 0.5F) / static_cast<float>(width) * n_s;
      const int i = std::min(static_cast<int>(u), n_s - 1);
      const float* row = &light[static_cast<std::size_t>(j) * static_cast<std::size_t>(n_s + 1) +
                                static_cast<std::size_t>(i)];
      const float* next = row + n_s + 1;
      const float a = u - i, b = v - j;
      const float lit =
          (row[0] * (1 - a) + row[1] * a) * (1 - b) + (next[0] * (1 - a) + next[1] * a) * b;
      const Colour c = texture.at((x + 0.5F) * static_cast<float>(step_s),
                                  (y + 0.5F) * static_cast<float>(step_t));
      Texel out{};
      for (std::size_t k = 0; k < 3; ++k)
        out[k] = static_cast<std::uint8_t>(std::clamp(c[k] * lit * kWhiteGrey, 0.0F, 255.0F));
      texels.push_back(out);
    }
  }
  picture_ = std::make_unique<const MipMap>(width, height, texels, Beyond::kBorder);
}

}  // namespace fusion_slam
