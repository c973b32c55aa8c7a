// Furniture as boxes. `foot`: the middle of its footprint, z of its lower face; x of the thing
// points along yaw. Metres, radians.
#pragma once

#include <vector>

#include "drivers/simulator/scene.hpp"

namespace fusion_slam {

Box standing_box(const Eigen::Vector3d& foot, double yaw_rad, const Eigen::Vector3d& size_m,
                 const Material& material);
// A top on four legs and a panel at its back (-y) side.
void add_desk(const Eigen::Vector3d& foot, double yaw_rad, const Eigen::Vector3d& size_m,
              const Material& material, std::vector<Box>* boxes);
// A top on four legs.
void add_table(const Eigen::Vector3d& foot, double yaw_rad, const Eigen::Vector3d& size_m,
               const Material& material, std::vector<Box>* boxes);
// A seat on four thin legs with a back at -x: who sits looks along x.
void add_chair(const Eigen::Vector3d& foot, double yaw_rad, const Material& material,
               std::vector<Box>* boxes);

}  // namespace fusion_slam
