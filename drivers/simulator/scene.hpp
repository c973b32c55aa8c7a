// What rays hit: boxes and meshes. World frame: x, y on the floor, z up, metres. The rays are
// Embree's (Wald et al. 2014), single ones for the LiDAR and shadows, eight at a time for the
// camera. Everything const is thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/simulator/mesh.hpp"
#include "libs/evaluation/map_class.hpp"
#include "libs/geometry/pose.hpp"

namespace fusion_slam {

enum class TextureKind {
  kPlaster,
  kCarpet,
  kWood,
  kBrick,
  kPaper,
  kPoster,
  kBooks,
  kDrawers,
  kScreen,
  kCardboard,
  kTiles,
  kFabric
};

struct Material {
  TextureKind kind = TextureKind::kPlaster;
  std::array<float, 3> bgr{0.8F, 0.8F, 0.8F};  // 0 to 1
  std::uint64_t seed = 0;
};

struct Box {
  SE3 T_world_box = SE3::Identity();  // box frame: origin in its centre
  Eigen::Vector3d half_m = Eigen::Vector3d::Zero();
  Material material;
  ObstacleClass obstacle = ObstacleClass::kOther;  // of the true map
};

// Outward normal of a box's face in the box's frame. Faces: 2 * axis + (1 when the outward normal
// points along +axis).
Eigen::Vector3d face_normal(int face);

struct SceneHit {
  double t = 0.0;  // in lengths of the direction
  int box = -1;    // -1: it is a mesh
  int face = 0;    // of the box
  int mesh = -1;   // -1: it is a box
  int triangle = 0;
  float u = 0.0F;  // of the triangle: p = (1 - u - v) v0 + u v1 + v v2
  float v = 0.0F;
};

// Eight rays from one point and what they meet. t > 0 in lengths of the direction; infinity:
// nothing. geometry 0: boxes, primitive = box * 6 + face; k > 0: mesh k - 1, primitive = triangle.
struct alignas(32) RayPacket {
  std::array<float, 8> x, y, z;  // directions
  std::array<float, 8> t;
  std::array<float, 8> u, v;
  std::array<float, 8> cosine;  // of the angle between ray and surface normal, 0 to 1
  std::array<std::int32_t, 8> geometry, primitive;
};

class Scene {
 public:
  explicit Scene(std::vector<Box> boxes, std::vector<Mesh> meshes = {});
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  const std::vector<Box>& boxes() const { return boxes_; }
  const std::vector<Mesh>& meshes() const { return meshes_; }
  // First box that the ray enters, or mesh that it meets from either side, with 0 < t < t_max. A
  // ray that starts within a box does not see that box. t is exact to double precision where
  // Embree's floats agree which surface it is.
  std::optional<SceneHit> cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                               double t_max = std::numeric_limits<double>::infinity()) const;
  // Whether there is such a surface at all.
  bool blocked(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
               double t_max = std::numeric_limits<double>::infinity()) const;
  // x, y, z are given, the rest is the answer. within_a_box: says whether `origin` is.
  void cast(const Eigen::Vector3f& origin, bool within_a_box, float t_min, RayPacket* rays) const;
  bool within_a_box(const Eigen::Vector3d& p) const;

  Eigen::Vector3d normal(const SceneHit& hit) const;  // unit; a box's outward; world
  // Part of the light that the surface sends back, 0 to 1, its average over about 2 cm.
  double reflectance(const SceneHit& hit) const;
  ObstacleClass obstacle(const SceneHit& hit) const;

 private:
  struct Tree;  // Embree's
  std::vector<Box> boxes_;
  std::vector<Mesh> meshes_;
  std::vector<SE3> T_box_world_;
  std::unique_ptr<Tree> tree_;
};

}  // namespace fusion_slam
