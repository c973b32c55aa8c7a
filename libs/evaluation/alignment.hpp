// Moves an estimate into the frame of its reference before they are compared.
#pragma once

#include <string_view>
#include <vector>

#include "libs/evaluation/association.hpp"
#include "libs/evaluation/outcome.hpp"
#include "libs/evaluation/trajectory.hpp"

namespace fusion_slam {

enum class Alignment {
  kNone,    // compare as they are
  kOrigin,  // first matched poses coincide (position and attitude)
  kSe3,     // least squares over all matched positions, rotation and translation
  kSim3,    // the same with scale (monocular estimates)
};

std::string_view name_of(Alignment alignment);  // "none", "origin", "se3", "sim3"

// p_to = T_to_from * (scale * p_from)
struct Similarity {
  double scale = 1.0;
  SE3 T_to_from = SE3::Identity();

  Eigen::Vector3d operator*(const Eigen::Vector3d& p_from) const;
  SE3 operator*(const SE3& pose_in_from) const;  // position scaled and moved, attitude turned
};

// Least squares of sum |to_i - S * from_i|^2 in closed form: Umeyama 1991, equations 34 to 43.
// Never a reflection. Equally long lists, metres. Fails for fewer than 3 points and for points on
// one line (or in one place), about which the rotation is not determined.
Outcome<Similarity> umeyama(const std::vector<Eigen::Vector3d>& from,
                            const std::vector<Eigen::Vector3d>& to, bool with_scale);

// The similarity that takes the estimate to the reference.
Outcome<Similarity> find_alignment(const MatchedPoses& matched, Alignment alignment);

Trajectory transform(const Similarity& S, const Trajectory& trajectory);

}  // namespace fusion_slam
