#include "services/lidar_mapper/pose_filter.hpp"

#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

Eigen::Matrix3d diagonal(double x, double y, double yaw) {
  return Eigen::Vector3d(x * x, y * y, yaw * yaw).asDiagonal();
}

// Against drawing many robots: each moves with its own errors.
TEST(PoseFilter, DeadReckoningSpreadsAsManyRobotsDo) {
  const SE2 step{0.3, 0.02, 0.15};
  const Eigen::Matrix3d noise = diagonal(0.02, 0.01, 0.02);
  PoseFilter filter;
  for (int i = 0; i < 3; ++i) filter.predict(step, noise);
  filter.clone();
  SE2 T_node_now;
  for (int i = 0; i < 4; ++i) {
    filter.predict(step, noise);
    T_node_now = T_node_now * step;
  }
  std::mt19937 rng(1);
  std::normal_distribution<double> n;
  Eigen::Matrix3d since_node = Eigen::Matrix3d::Zero(), now = Eigen::Matrix3d::Zero();
  const int robots = 20000;
  for (int k = 0; k < robots; ++k) {
    SE2 truth, believed, node_truth, node_believed;
    for (int i = 0; i < 7; ++i) {
      if (i == 3) node_truth = truth, node_believed = believed;
      believed = believed * step;
      truth = truth * step * SE2{0.02 * n(rng), 0.01 * n(rng), 0.02 * n(rng)};
    }
    const SE2 e = believed.inverse() * truth;
    const SE2 r = (node_believed.inverse() * believed).inverse() * (node_truth.inverse() * truth);
    const Eigen::Vector3d v(e.x, e.y, e.yaw), w(r.x, r.y, r.yaw);
    now += v * v.transpose() / robots;
    since_node += w * w.transpose() / robots;
  }
  EXPECT_LT((filter.covariance() - now).norm(), 0.06 * now.norm());
  EXPECT_LT((filter.since_node(T_node_now) - since_node).norm(), 0.06 * since_node.norm());
}

// Along a corridor nothing is seen: the uncertainty in the map grows, that since the last node is
// only what the motion added.
TEST(PoseFilter, WhatTwoPosesShareDoesNotCountBetweenThem) {
  PoseFilter filter;
  const Eigen::Matrix3d noise = diagonal(0.05, 0.05, 0.02);
  const Eigen::Matrix3d across =
      Eigen::Vector3d(0.0, 1.0 / 0.01 / 0.01, 1.0 / 0.005 / 0.005).asDiagonal();
  for (int i = 0; i < 100; ++i) {
    filter.predict({0.2, 0.0, 0.0}, noise);
    filter.update(across);
    if (i == 98) filter.clone();
  }
  EXPECT_NEAR(std::sqrt(filter.covariance()(0, 0)), 0.05 * 10.0, 0.02);
  EXPECT_LT(std::sqrt(filter.covariance()(1, 1)), 0.0101);
  const Eigen::Matrix3d since = filter.since_node({0.2, 0.0, 0.0});
  EXPECT_NEAR(std::sqrt(since(0, 0)), 0.05, 0.002);
  EXPECT_LT(std::sqrt(since(1, 1)), 0.02);
  EXPECT_GT(Eigen::Matrix3d(since).determinant(), 0.0);
}

TEST(PoseFilter, UpdateIsKalmans) {
  PoseFilter filter;
  filter.predict({0.1, 0.0, 0.2}, diagonal(0.1, 0.2, 0.05));
  filter.clone();
  filter.predict({0.2, 0.1, -0.3}, diagonal(0.1, 0.1, 0.1));
  const Eigen::Matrix3d P = filter.covariance(), R = diagonal(0.03, 0.08, 0.02);
  filter.update(R.inverse());
  const Eigen::Matrix3d expected = (P.inverse() + R.inverse()).inverse();
  EXPECT_LT((filter.covariance() - expected).norm(), 1e-12);
  filter.reset();
  EXPECT_EQ(filter.covariance().norm(), 0.0);
}

}  // namespace
}  // namespace fusion_slam
