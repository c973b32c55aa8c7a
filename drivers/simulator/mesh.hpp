// Triangles with a picture on them: what comes from model files.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/simulator/mip_map.hpp"
#include "libs/evaluation/map_class.hpp"
#include "libs/geometry/pose.hpp"

namespace fusion_slam {

struct Mesh {
  std::string name;  // of the model in its world
  ObstacleClass obstacle = ObstacleClass::kOther;
  std::vector<Eigen::Vector3f> vertices_m;  // world (of a file: the model's frame, z up)
  std::vector<Eigen::Vector3f> normals;     // unit length, one for each vertex
  std::vector<Eigen::Vector2f>
      uv;  // one for each vertex, (0, 0) at the picture's lower left; or none
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::array<float, 3> bgr{0.8F, 0.8F, 0.8F};  // reflectance, 0 to 1; with a picture: times it
  std::shared_ptr<const MipMap> picture;       // repeated beyond its borders; may be missing
};

// The mesh moved and, before that, scaled along its own axes.
inline Mesh placed(Mesh mesh, const SE3& T_world_mesh,
                   const Eigen::Vector3d& scale = Eigen::Vector3d::Ones()) {
  const Eigen::Matrix3d A = T_world_mesh.linear() * scale.asDiagonal();
  const Eigen::Matrix3d N = T_world_mesh.linear() * scale.cwiseInverse().asDiagonal();
  for (Eigen::Vector3f& v : mesh.vertices_m)
    v = (A * v.cast<double>() + T_world_mesh.translation()).cast<float>();
  for (Eigen::Vector3f& n : mesh.normals) n = (N * n.cast<double>()).normalized().cast<float>();
  return mesh;
}

}  // namespace fusion_slam
