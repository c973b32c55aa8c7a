#include "drivers/simulator/mesh_shapes.hpp"

#include <cmath>

namespace fusion_slam {
namespace {

constexpr std::uint32_t kAround = 32;  // corners of a circle

std::uint32_t add(Mesh* mesh, const Eigen::Vector3d& p, const Eigen::Vector3d& normal) {
  mesh->vertices_m.emplace_back(p.cast<float>());
  mesh->normals.emplace_back(normal.cast<float>());
  return static_cast<std::uint32_t>(mesh->vertices_m.size() - 1);
}

// Four corners counter-clockwise as seen from where the normal points to.
void add_quad(Mesh* mesh, const std::array<Eigen::Vector3d, 4>& p, const Eigen::Vector3d& normal) {
  const std::uint32_t first = add(mesh, p[0], normal);
  for (std::size_t i = 1; i < 4; ++i) add(mesh, p[i], normal);
  mesh->triangles.push_back({first, first + 1, first + 2});
  mesh->triangles.push_back({first, first + 2, first + 3});
}

Eigen::Vector3d around(std::uint32_t i) {
  const double angle = 2.0 * M_PI * i / kAround;
  return {std::cos(angle), std::sin(angle), 0.0};
}

}  // namespace

Mesh box_mesh(const Eigen::Vector3d& size_m) {
  Mesh mesh;
  const Eigen::Vector3d half = 0.5 * size_m;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      Eigen::Vector3d n = Eigen::Vector3d::Zero(), a = Eigen::Vector3d::Zero();
      n[axis] = side;
      a[(axis + 1) % 3] = 1.0;
      const Eigen::Vector3d b = n.cross(a);
      const auto at = [&](double i, double j) {
        return Eigen::Vector3d(half.cwiseProduct(n + i * a + j * b));
      };
      add_quad(&mesh, {at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)}, n);
    }
  return mesh;
}

Mesh plane_mesh(double width_m, double depth_m) {
  Mesh mesh;
  const double x = 0.5 * width_m, y = 0.5 * depth_m;
  add_quad(&mesh,
           {Eigen::Vector3d(-x, -y, 0), Eigen::Vector3d(x, -y, 0), Eigen::Vector3d(x, y, 0),
            Eigen::Vector3d(-x, y, 0)},
           Eigen::Vector3d::UnitZ());
  return mesh;
}

Mesh cylinder_mesh(double radius_m, double length_m) {
  Mesh mesh;
  const Eigen::Vector3d up(0.0, 0.0, 0.5 * length_m);
  const std::uint32_t top = add(&mesh, up, Eigen::Vector3d::UnitZ());
  const std::uint32_t bottom = add(&mesh, -up, -Eigen::Vector3d::UnitZ());
  const std::uint32_t first = bottom + 1;
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const Eigen::Vector3d out = around(i), at = radius_m * out;
    add(&mesh, at - up, out);
    add(&mesh, at + up, out);
    add(&mesh, at - up, -Eigen::Vector3d::UnitZ());
    add(&mesh, at + up, Eigen::Vector3d::UnitZ());
  }
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const std::uint32_t a = first + 4 * i, b = first + 4 * ((i + 1) % kAround);
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
    mesh.triangles.push_back({bottom, b + 2, a + 2});
    mesh.triangles.push_back({top, a + 3, b + 3});
  }
  return mesh;
}

Mesh sphere_mesh(double radius_m) {
  Mesh mesh;
  constexpr std::uint32_t kRings = kAround / 2;
  for (std::uint32_t j = 0; j <= kRings; ++j) {
    const double from_pole = M_PI * j / kRings;
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const Eigen::Vector3d out =
          std::sin(from_pole) * around(i) + std::cos(from_pole) * Eigen::Vector3d::UnitZ();
      add(&mesh, radius_m * out, out);
    }
  }
  for (std::uint32_t j = 0; j < kRings; ++j)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const std::uint32_t a = j * kAround + i, b = j * kAround + (i + 1) % kAround;
      if (j > 0) mesh.triangles.push_back({a, b + kAround, b});
      if (j + 1 < kRings) mesh.triangles.push_back({a, a + kAround, b + kAround});
    }
  return mesh;
}

}  // namespace fusion_slam
