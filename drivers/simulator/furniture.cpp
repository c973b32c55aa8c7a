#include "drivers/simulator/furniture.hpp"

#include "drivers/simulator/texture.hpp"

namespace fusion_slam {
namespace {

// A box at (x, y, z of its lower face) of a thing.
Box part(const Eigen::Vector3d& foot, double yaw_rad, const Eigen::Vector3d& at,
         const Eigen::Vector3d& size_m, const Material& material) {
  const SE3 T_world_thing = from_xyz_rpy(foot.x(), foot.y(), foot.z(), 0.0, 0.0, yaw_rad);
  return standing_box(T_world_thing * at, yaw_rad, size_m, material);
}

void add_legs(const Eigen::Vector3d& foot, double yaw_rad, double x, double y, double height,
              double width, const Material& material, std::vector<Box>* boxes) {
  for (const double sx : {-1.0, 1.0})
    for (const double sy : {-1.0, 1.0})
      boxes->push_back(
          part(foot, yaw_rad, {sx * x, sy * y, 0.0}, {width, width, height}, material));
}

}  // namespace

Box standing_box(const Eigen::Vector3d& foot, double yaw_rad, const Eigen::Vector3d& size_m,
                 const Material& material) {
  Box box;
  box.T_world_box =
      from_xyz_rpy(foot.x(), foot.y(), foot.z() + 0.5 * size_m.z(), 0.0, 0.0, yaw_rad);
  box.half_m = 0.5 * size_m;
  box.material = material;
  return box;
}

void add_desk(const Eigen::Vector3d& foot, double yaw_rad, const Eigen::Vector3d& size_m,
              const Material& material, std::vector<Box>* boxes) {
  const double top = 0.03, leg = 0.045;
  const double under = size_m.z() - top;
  const Material metal{TextureKind::kPlaster, {0.35F, 0.34F, 0.33F}, material.seed + 1000};
  boxes->push_back(part(foot, yaw_rad, {0, 0, under}, {size_m.x(), size_m.y(), top}, material));
  add_legs(foot, yaw_rad, 0.5 * size_m.x() - 0.06, 0.5 * size_m.y() - 0.06, under, leg, metal,
           boxes);
  boxes->push_back(part(foot, yaw_rad, {0, 0.05 - 0.5 * size_m.y(), under - 0.36},
                        {size_m.x() - 0.2, 0.018, 0.36}, material));
}

void add_table(const Eigen::Vector3d& foot, double yaw_rad, const Eigen::Vector3d& size_m,
               const Material& material, std::vector<Box>* boxes) {
  const double top = 0.04, leg = 0.05;
  const double under = size_m.z() - top;
  const Material legs{TextureKind::kWood, {0.16F, 0.24F, 0.34F}, material.seed + 1000};
  boxes->push_back(part(foot, yaw_rad, {0, 0, under}, {size_m.x(), size_m.y(), top}, material));
  add_legs(foot, yaw_rad, 0.5 * size_m.x() - 0.05, 0.5 * size_m.y() - 0.05, under, leg, legs,
           boxes);
}

void add_chair(const Eigen::Vector3d& foot, double yaw_rad, const Material& material,
               std::vector<Box>* boxes) {
  const double side = 0.42, seat = 0.45;
  const Material metal{TextureKind::kPlaster, {0.22F, 0.22F, 0.22F}, material.seed + 1000};
  boxes->push_back(part(foot, yaw_rad, {0, 0, seat - 0.05}, {side, side, 0.05}, material));
  add_legs(foot, yaw_rad, 0.5 * side - 0.02, 0.5 * side - 0.02, seat - 0.05, 0.025, metal, boxes);
  for (const double y : {-1.0, 1.0})
    boxes->push_back(part(foot, yaw_rad, {0.02 - 0.5 * side, y * (0.5 * side - 0.04), seat},
                          {0.025, 0.025, 0.4}, metal));
  boxes->push_back(
      part(foot, yaw_rad, {0.02 - 0.5 * side, 0, seat + 0.16}, {0.035, side, 0.27}, material));
}

}  // namespace fusion_slam
