#pragma once

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

// T with the rounding of many products taken out of its rotation (by a normalised quaternion).
// Poses that are corrected again and again need it: inverse() of an isometry transposes, so each
// T_new * T_old.inverse() * T triples what the rotation lacks to be one. Pure, any thread.
inline SE3 orthonormal(const SE3& T) {
  SE3 result = SE3::Identity();
  result.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  result.translation() = T.translation();
  return result;
}

}  // namespace fusion_slam
