#include "libs/evaluation/pose_error.hpp"

#include <cmath>

namespace fusion_slam {

std::string_view name_of(ErrorRelation relation) {
  switch (relation) {
    case ErrorRelation::kTranslation:
      return "translation";
    case ErrorRelation::kRotation:
      return "rotation";
    case ErrorRelation::kFull:
      return "full";
  }
  return "";
}

std::string_view unit_of(ErrorRelation relation) {
  switch (relation) {
    case ErrorRelation::kTranslation:
      return "m";
    case ErrorRelation::kRotation:
      return "deg";
    case ErrorRelation::kFull:
      return "";
  }
  return "";
}

double pose_error(const SE3& E, ErrorRelation relation) {
  switch (relation) {
    case ErrorRelation::kTranslation:
      return E.translation().norm();
    case ErrorRelation::kRotation:
      return log_so3(E.linear()).norm() * 180.0 / M_PI;
    case ErrorRelation::kFull:
      return (E.matrix() - Eigen::Matrix4d::Identity()).norm();
  }
  return 0.0;
}

}  // namespace fusion_slam
