// Made-up trajectories for the tests of libs/evaluation; seeded, so that every run sees the same.
#pragma once

#include <cmath>
#include <random>

#include "libs/evaluation/trajectory.hpp"

namespace fusion_slam {

inline Eigen::Vector3d random_vector(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  const double x = uniform(random);
  const double y = uniform(random);
  const double z = uniform(random);
  return {x, y, z};
}

inline SE3 random_pose(std::mt19937& random, double size_m, double angle_rad) {
  SE3 T = SE3::Identity();
  T.translation() = random_vector(random, size_m);
  T.linear() = exp_so3(random_vector(random, angle_rad));
  return T;
}

// A smooth walk in all three dimensions that also stands still for a while; 10 Hz.
inline Trajectory random_walk(std::mt19937& random, std::size_t count) {
  Trajectory walk;
  SE3 T = random_pose(random, 1.0, 1.0);
  for (std::size_t i = 0; i < count; ++i) {
    walk.push_back({0.1 * static_cast<double>(i), T});
    const bool stands = i % 50 > 40;
    if (!stands) T = T * random_pose(random, 0.1, 0.1);
  }
  return walk;
}

inline Trajectory with_noise(std::mt19937& random, const Trajectory& walk, double size_m,
                             double angle_rad) {
  Trajectory noisy = walk;
  for (StampedPose& pose : noisy) {
    pose.T_world_body = pose.T_world_body * random_pose(random, size_m, angle_rad);
  }
  return noisy;
}

inline Trajectory moved(const SE3& T, Trajectory walk) {
  for (StampedPose& pose : walk) pose.T_world_body = T * pose.T_world_body;
  return walk;
}

}  // namespace fusion_slam
