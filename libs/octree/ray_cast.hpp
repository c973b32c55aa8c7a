// The voxels between two points, in order (Amanatides & Woo 1987, "A fast voxel traversal algorithm
// for ray tracing").
#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Core>

namespace fusion_slam {

// Calls visit(x, y, z) for each voxel from the one of `from` to the one of `to`, both included.
// Points are in voxels (metres divided by the resolution) and must be finite.
template <class Visit>
void cast_ray(const Eigen::Vector3d& from, const Eigen::Vector3d& to, Visit visit) {
  const Eigen::Vector3d direction = to - from;
  Eigen::Array3i voxel;
  Eigen::Array3i last;
  Eigen::Array3i step;
  Eigen::Array3d next;   // ray parameter (0 at from, 1 at to) at the next face across each axis
  Eigen::Array3d delta;  // and from face to face
  int remaining = 0;
  for (int axis = 0; axis < 3; ++axis) {
    voxel[axis] = static_cast<int>(std::floor(from[axis]));
    last[axis] = static_cast<int>(std::floor(to[axis]));
    const double d = direction[axis];
    step[axis] = last[axis] < voxel[axis] ? -1 : 1;
    const double face = step[axis] > 0 ? voxel[axis] + 1.0 : voxel[axis];
    const bool moves = last[axis] != voxel[axis];
    next[axis] = moves ? (face - from[axis]) / d : std::numeric_limits<double>::infinity();
    delta[axis] = moves ? std::abs(1.0 / d) : std::numeric_limits<double>::infinity();
    remaining += std::abs(last[axis] - voxel[axis]);
  }
  visit(voxel[0], voxel[1], voxel[2]);
  for (; remaining > 0; --remaining) {
    int axis = next[0] <= next[1] ? 0 : 1;
    if (next[2] < next[axis]) axis = 2;
    voxel[axis] += step[axis];
    if (voxel[axis] == last[axis])
      next[axis] = std::numeric_limits<double>::infinity();  // never beyond the end
    else
      next[axis] += delta[axis];
    visit(voxel[0], voxel[1], voxel[2]);
  }
}

}  // namespace fusion_slam
