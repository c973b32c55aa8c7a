// What rays hit: boxes. World frame: x, y on the floor, z up, metres. Everything const is
// thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

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

// Faces of a box: 2 * axis + (1 when the outward normal points along +axis).
struct BoxHit {
  double t = 0.0;  // in lengths of the direction
  int face = 0;
};

// Entry of the ray origin + t * direction (both in the box's frame) with t > 0; a ray that starts
// inside never enters. Slab method (Kay & Kajiya 1986).
inline bool enter_box(const Eigen::Vector3d& half, const Eigen::Vector3d& origin,
                      const Eigen::Vector3d& direction, BoxHit* hit) {
  double enter = 0.0;
  double leave = std::numeric_limits<double>::infinity();
  int face = -1;
  for (int axis = 0; axis < 3; ++axis) {
    const double inverse = 1.0 / direction[axis];
    const double low = (-half[axis] - origin[axis]) * inverse;
    const double high = (half[axis] - origin[axis]) * inverse;
    const double near = low < high ? low : high;
    const double far = low < high ? high : low;
    if (near > enter) {
      enter = near;
      face = 2 * axis + (direction[axis] < 0.0 ? 1 : 0);
    }
    if (far < leave) leave = far;
  }
  if (face < 0 || enter > leave) return false;
  *hit = {enter, face};
  return true;
}

Eigen::Vector3d face_normal(int face);  // in the box's frame

struct SceneHit {
  double t = 0.0;
  int box = 0;
  int face = 0;
};

class Scene {
 public:
  explicit Scene(std::vector<Box> boxes);

  const std::vector<Box>& boxes() const { return boxes_; }
  // First box that the ray enters with t < t_max.
  std::optional<SceneHit> cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                               double t_max = std::numeric_limits<double>::infinity()) const;
  Eigen::Vector3d normal(const SceneHit& hit) const;  // outward, world

 private:
  std::vector<Box> boxes_;
  std::vector<SE3> T_box_world_;
};

}  // namespace fusion_slam
