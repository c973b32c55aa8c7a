#include "drivers/simulator/lighting.hpp"

#include <cmath>

namespace fusion_slam {
namespace {
constexpr double kFittingM = 0.25;  // a lamp's own glass and frame throw no shadow
}

double light_at(const Scene& scene, const Lighting& lighting, const Eigen::Vector3d& p,
                const Eigen::Vector3d& normal) {
  double light = lighting.ambient * (1.0 + 0.15 * normal.x() + 0.1 * normal.y());
  for (std::size_t i = 0; i < lighting.lamps_m.size(); ++i) {
    const Eigen::Vector3d to_lamp = lighting.lamps_m[i] - p;
    const double distance = to_lamp.norm();
    const double cosine = normal.dot(to_lamp) / distance;
    const double clear = 1.0 - kFittingM / distance;
    if (!(cosine > 0.0) || (clear > 0.0 && scene.blocked(p, to_lamp, clear))) continue;
    const double scale = i < lighting.lamp_scale.size() ? lighting.lamp_scale[i] : 1.0;
    light += scale * lighting.lamp_power * cosine / (1.0 + distance * distance);
  }
  return light;
}

double open_sky(const Scene& scene, const Eigen::Vector3d& p, const Eigen::Vector3d& normal,
                double reach_m, int n_rays) {
  // Any two directions across the normal.
  const Eigen::Vector3d across =
      std::fabs(normal.z()) < 0.9 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d a = across.cross(normal).normalized();
  const Eigen::Vector3d b = normal.cross(a);
  constexpr double kGoldenRad = 2.399963229728653;  // a spiral that leaves no gaps (Vogel 1979)
  double open = 0.0;
  for (int i = 0; i < n_rays; ++i) {
    const double radius2 = (i + 0.5) / n_rays;
    const double radius = std::sqrt(radius2), angle = kGoldenRad * i;
    const Eigen::Vector3d direction = radius * std::cos(angle) * a + radius * std::sin(angle) * b +
                                      std::sqrt(1.0 - radius2) * normal;
    if (!scene.blocked(p, direction, reach_m)) open += 1.0;
  }
  return open / n_rays;
}

}  // namespace fusion_slam
