// The size of an error transform, seen in three ways.
#pragma once

#include <string_view>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

enum class ErrorRelation {
  kTranslation,  // metres
  kRotation,     // rotation angle, degrees, 0 to 180
  kFull,         // Frobenius norm of (E - identity): metres and rotation mixed, no unit
};

std::string_view name_of(ErrorRelation relation);  // "translation", "rotation", "full"
std::string_view unit_of(ErrorRelation relation);  // "m", "deg", ""

// E is the transform that is the identity when there is no error.
double pose_error(const SE3& E, ErrorRelation relation);

}  // namespace fusion_slam
