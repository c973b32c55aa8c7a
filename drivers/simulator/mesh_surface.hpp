// A mesh's colours: its picture times the light that falls on it. Nothing moves, so the light is
// computed once, at the corners of small triangles and on a lattice in large ones.
#pragma once

#include <array>
#include <vector>

#include "drivers/simulator/lighting.hpp"
#include "drivers/simulator/scene.hpp"

namespace fusion_slam {

// const and thread-safe after construction.
class MeshSurface {
 public:
  // Keeps a reference to the scene's mesh.
  MeshSurface(const Scene& scene, const Lighting& lighting, int mesh);
  // Blue, green, red, 0 to 255, at the triangle's (u, v) (see SceneHit) as seen by a pixel that
  // covers footprint_m of it.
  std::array<float, 3> at(std::int32_t triangle, float u, float v, float footprint_m) const;
  // The same for eight pixels next to each other, which cover about the same. One mip level
  // serves them all unless the picture's scale changes between them.
  void at(const std::array<std::int32_t, 8>& triangle, const std::array<float, 8>& u,
          const std::array<float, 8>& v, float footprint_m,
          std::array<std::array<float, 4>, 8>* bgr) const;

 private:
  struct Triangle {
    std::array<float, 3> x, y;  // of the corners, in texels of the picture
    float texels_per_m = 0.0F;
    std::int32_t n = 1;     // parts in which the lattice divides each side
    std::size_t light = 0;  // n = 1: the corners' places are in `corners`; else the lattice's
    std::array<std::uint32_t, 3> corners{};
  };
  float light(const Triangle& triangle, float u, float v) const;

  const Mesh& mesh_;
  std::vector<Triangle> triangles_;
  std::vector<float> light_;  // of vertices, then lattices row by row: v = 0 has n + 1 points
};

}  // namespace fusion_slam
