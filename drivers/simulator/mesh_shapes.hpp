// Simple bodies as meshes, centred on the origin, of a plain colour. Metres.
#pragma once

#include "drivers/simulator/mesh.hpp"

namespace fusion_slam {

Mesh box_mesh(const Eigen::Vector3d& size_m);
Mesh plane_mesh(double width_m, double depth_m);       // at z = 0, looks up
Mesh cylinder_mesh(double radius_m, double length_m);  // along z, closed
Mesh sphere_mesh(double radius_m);

}  // namespace fusion_slam
