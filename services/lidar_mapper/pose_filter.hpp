// How uncertain is the robot's pose in the local map, and how uncertain its motion since the last
// node? Both need the errors' history: along a corridor they add up from scan to scan, and what two
// poses have in common does not count between them. An error-state filter over the pose now and a
// copy of it at the last node (stochastic cloning, Roumeliotis & Burdick 2002). One thread.
#pragma once

#include <Eigen/Core>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

// All covariances of xi in T * xi, (x, y, yaw) in the base axes of that pose.
class PoseFilter {
 public:
  // The robot moved by T_base(before)_base(now), known to `noise` (in axes of now).
  void predict(const SE2& motion, const Eigen::Matrix3d& noise);

  // A match whose points alone carry `information` about the pose now (singular along a corridor).
  void update(const Eigen::Matrix3d& information);

  // The pose now becomes the last node's.
  void clone();

  // Pose now, in the local map.
  Eigen::Matrix3d covariance() const { return joint_.bottomRightCorner<3, 3>(); }

  // Of T_node_now, given that pose.
  Eigen::Matrix3d since_node(const SE2& T_node_now) const;

  // A new map begins here: nothing is uncertain in it.
  void reset() { joint_.setZero(); }

 private:
  Matrix6d joint_ = Matrix6d::Zero();  // node, now
};

// How an error of `from` in its own axes shows at the end of T_from_to, in that end's axes.
Eigen::Matrix3d carry_error(const SE2& T_from_to);

}  // namespace fusion_slam
