#include "drivers/simulator/mesh_surface.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr double kLightStepM = 0.15;    // sides of larger triangles are divided
constexpr int kMaxParts = 96;           // of a side
constexpr double kLiftM = 0.01;         // light is measured this far above the surface
constexpr double kReachM = 0.8;         // of what takes ambient light away
constexpr double kScatteredPart = 0.3;  // ambient light that reaches the deepest corner
constexpr int kSkyRays = 24;

double light_on(const Scene& scene, const Lighting& lighting, const Eigen::Vector3f& p,
                const Eigen::Vector3f& normal) {
  const Eigen::Vector3d n = normal.cast<double>();
  const Eigen::Vector3d lifted = p.cast<double>() + kLiftM * n;
  Lighting lamps = lighting;
  lamps.ambient = 0.0;
  const double open = open_sky(scene, lifted, n, kReachM, kSkyRays);
  const double ambient = lighting.ambient * (1.0 + 0.15 * n.x() + 0.1 * n.y());
  return ambient * (kScatteredPart + (1.0 - kScatteredPart) * open) +
         light_at(scene, lamps, lifted, n);
}

// Lattice points in the rows before row j of n parts.
std::size_t row_begin(int n, int j) {
  return static_cast<std::size_t>(j * (n + 1) - j * (j - 1) / 2);
}

}  // namespace

MeshSurface::MeshSurface(const Scene& scene, const Lighting& lighting, int mesh)
    : mesh_(scene.meshes()[static_cast<std::size_t>(mesh)]) {
  const auto& p = mesh_.vertices_m;
  for (std::size_t i = 0; i < p.size(); ++i)
    light_.push_back(static_cast<float>(light_on(scene, lighting, p[i], mesh_.normals[i])));
  triangles_.reserve(mesh_.triangles.size());
  for (const auto& c : mesh_.triangles) {
    Triangle t;
    t.corners = c;
    const double area = 0.5 * (p[c[1]] - p[c[0]]).cross(p[c[2]] - p[c[0]]).norm();
    const double side = std::max(
        {(p[c[1]] - p[c[0]]).norm(), (p[c[2]] - p[c[1]]).norm(), (p[c[0]] - p[c[2]]).norm()});
    t.n = std::clamp(static_cast<int>(std::ceil(side / kLightStepM)), 1, kMaxParts);
    if (t.n > 1) {
      t.light = light_.size();
      for (int j = 0; j <= t.n; ++j)
        for (int i = 0; i + j <= t.n; ++i) {
          const float u = static_cast<float>(i) / static_cast<float>(t.n);
          const float v = static_cast<float>(j) / static_cast<float>(t.n);
          const float w = 1.0F - u - v;
          const Eigen::Vector3f at = w * p[c[0]] + u * p[c[1]] + v * p[c[2]];
          const Eigen::Vector3f normal =
              w * mesh_.normals[c[0]] + u * mesh_.normals[c[1]] + v * mesh_.normals[c[2]];
          light_.push_back(static_cast<float>(light_on(scene, lighting, at, normal.normalized())));
        }
    }
    if (mesh_.picture && !mesh_.uv.empty()) {
      for (std::size_t k = 0; k < 3; ++k) {
        t.x[k] = mesh_.uv[c[k]].x() * static_cast<float>(mesh_.picture->width());
        t.y[k] = (1.0F - mesh_.uv[c[k]].y()) * static_cast<float>(mesh_.picture->height());
      }
      const double texels = 0.5 * std::fabs((t.x[1] - t.x[0]) * (t.y[2] - t.y[0]) -
                                            (t.x[2] - t.x[0]) * (t.y[1] - t.y[0]));
      t.texels_per_m = static_cast<float>(std::sqrt(texels / std::max(area, 1e-12)));
    }
    triangles_.push_back(t);
  }
}

float MeshSurface::light(const Triangle& t, float u, float v) const {
  if (t.n == 1)
    return (1.0F - u - v) * light_[t.corners[0]] + u * light_[t.corners[1]] +
           v * light_[t.corners[2]];
  const auto n = static_cast<float>(t.n);
  const int i = std::clamp(static_cast<int>(u * n), 0, t.n - 1);
  const int j = std::clamp(static_cast<int>(v * n), 0, t.n - 1 - i);
  const float a = u * n - static_cast<float>(i), b = v * n - static_cast<float>(j);
  const float* row = &light_[t.light + row_begin(t.n, j) + static_cast<std::size_t>(i)];
  const float* next = &light_[t.light + row_begin(t.n, j + 1) + static_cast<std::size_t>(i)];
  if (a + b <= 1.0F || i + j + 2 > t.n)
    return row[0] + a * (row[1] - row[0]) + b * (next[0] - row[0]);
  return next[1] + (1.0F - a) * (next[0] - next[1]) + (1.0F - b) * (row[1] - next[1]);
}

std::array<float, 3> MeshSurface::at(std::int32_t triangle, float u, float v,
                                     float footprint_m) const {
  const Triangle& t = triangles_[static_cast<std::size_t>(triangle)];
  const float lit = light(t, u, v);
  std::array<float, 3> bgr = mesh_.bgr;
  if (mesh_.picture && !mesh_.uv.empty()) {
    const float w = 1.0F - u - v;
    const auto seen =
        mesh_.picture->at(w * t.x[0] + u * t.x[1] + v * t.x[2],
                          w * t.y[0] + u * t.y[1] + v * t.y[2], footprint_m * t.texels_per_m);
    for (std::size_t k = 0; k < 3; ++k) bgr[k] *= seen[k] * (1.0F / 255.0F);
  }
  for (float& c : bgr) c = std::min(255.0F, c * lit * kWhiteGrey);
  return bgr;
}

void MeshSurface::at(const std::array<std::int32_t, 8>& triangle, const std::array<float, 8>& u,
                     const std::array<float, 8>& v, float footprint_m,
                     std::array<std::array<float, 4>, 8>* bgr) const {
  float least = 1e30F, most = 0.0F;
  for (const std::int32_t i : triangle) {
    const float scale = triangles_[static_cast<std::size_t>(i)].texels_per_m;
    least = std::min(least, scale);
    most = std::max(most, scale);
  }
  if (!mesh_.picture || mesh_.uv.empty() || most > 1.5F * least) {
    for (std::size_t k = 0; k < 8; ++k) {
      const auto c = at(triangle[k], u[k], v[k], footprint_m);
      (*bgr)[k] = {c[0], c[1], c[2], 0.0F};
    }
    return;
  }
  alignas(32) std::array<float, 8> x, y, lit;
  for (std::size_t k = 0; k < 8; ++k) {
    const Triangle& t = triangles_[static_cast<std::size_t>(triangle[k])];
    const float w = 1.0F - u[k] - v[k];
    x[k] = w * t.x[0] + u[k] * t.x[1] + v[k] * t.x[2];
    y[k] = w * t.y[0] + u[k] * t.y[1] + v[k] * t.y[2];
    lit[k] = light(t, u[k], v[k]) * (kWhiteGrey / 255.0F);
  }
  mesh_.picture->at(x, y, footprint_m * most, bgr);
  for (std::size_t k = 0; k < 8; ++k)
    for (std::size_t c = 0; c < 3; ++c)
      (*bgr)[k][c] = std::min(255.0F, (*bgr)[k][c] * mesh_.bgr[c] * lit[k]);
}

}  // namespace fusion_slam
