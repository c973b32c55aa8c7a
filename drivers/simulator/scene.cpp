#include "drivers/simulator/scene.hpp"

#include <utility>

namespace fusion_slam {

Eigen::Vector3d face_normal(int face) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  normal[face / 2] = face % 2 == 1 ? 1.0 : -1.0;
  return normal;
}

Scene::Scene(std::vector<Box> boxes) : boxes_(std::move(boxes)) {
  for (const Box& box : boxes_) T_box_world_.push_back(box.T_world_box.inverse());
}

std::optional<SceneHit> Scene::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                    double t_max) const {
  std::optional<SceneHit> best;
  BoxHit hit;
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    // Most boxes are far from the ray: their bounding sphere says so for less.
    const Eigen::Vector3d to_centre = boxes_[i].T_world_box.translation() - origin;
    const double along = to_centre.dot(direction) / direction.squaredNorm();
    const double off2 = (to_centre - along * direction).squaredNorm();
    if (off2 > boxes_[i].half_m.squaredNorm()) continue;
    const Eigen::Vector3d o = T_box_world_[i] * origin;
    const Eigen::Vector3d d = T_box_world_[i].linear() * direction;
    if (!enter_box(boxes_[i].half_m, o, d, &hit) || hit.t >= t_max) continue;
    t_max = hit.t;
    best = SceneHit{hit.t, static_cast<int>(i), hit.face};
  }
  return best;
}

Eigen::Vector3d Scene::normal(const SceneHit& hit) const {
  return boxes_[static_cast<std::size_t>(hit.box)].T_world_box.linear() * face_normal(hit.face);
}

}  // namespace fusion_slam
