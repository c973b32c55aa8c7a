// A long drive in the same place, and the graph it is fed to.
#pragma once

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <vector>

#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {

inline NodeId node(std::int64_t id) { return {NodeKind::kKeyframe, id}; }

// Round and round a block of 24 m in 20 s; loops lead back to where the robot was a round before
// and in the first one.
class Rounds {
 public:
  static constexpr int kPerRound = 24;

  explicit Rounds(int n_nodes) {
    std::mt19937 random(5);
    std::normal_distribution<double> gauss;
    const auto noisy = [&](const SE3& T, double m, double rad) {
      Vector6d xi;
      xi << m * gauss(random), m * gauss(random), 0.0, 0.0, 0.0, rad * gauss(random);
      return retract(T, xi);
    };
    for (int i = 0; i < n_nodes; ++i) {
      NodeInput input;
      input.id = node(i + 1);
      input.utime_us = utime_us(i);
      input.previous_id = i;
      if (i > 0) input.T_previous_base = noisy(truth(i - 1).inverse() * truth(i), 0.001, 0.0005);
      input.covariance = Matrix6d::Identity() * 1e-6;
      nodes.push_back(input);
      for (const int before : {i - kPerRound, i % kPerRound})
        if (before >= 0 && before < i && i % 2 == 0)
          loops[i].push_back({node(before + 1),
                              node(i + 1),
                              noisy(truth(before).inverse() * truth(i), 0.002, 0.0005),
                              Matrix6d::Identity() * 4e-6,
                              {}});
    }
  }
  static std::int64_t utime_us(int i) { return 1'000'000 + i * (20'000'000 / kPerRound); }
  static SE3 truth(int i) {
    const double a = 2.0 * M_PI * i / kPerRound;
    return from_xyz_rpy(3.8 * std::sin(a), 3.8 * (1.0 - std::cos(a)), 0, 0, 0, a);
  }
  // Nodes [from, to).
  void feed(PoseGraph* graph, int from, int to) const {
    for (int i = from; i < to; ++i) {
      graph->add_node(nodes[static_cast<std::size_t>(i)]);
      PoseInput pose;
      pose.utime_us = utime_us(i);
      pose.state = PoseState::kOk;
      pose.reference = node(i + 1);
      graph->add_pose(pose);
      const auto found = loops.find(i);
      if (found == loops.end()) continue;
      for (const LoopInput& loop : found->second) graph->add_loop(loop);
    }
  }

  std::vector<NodeInput> nodes;
  std::map<int, std::vector<LoopInput>> loops;
};

inline PoseGraph camera_graph(bool thinned, PoseGraphConfig config = {}) {
  if (!thinned) config.thinning.enough = std::numeric_limits<int>::max();
  PoseGraph graph(config);
  RobotModel robot;
  robot.has_camera = true;
  robot.has_lidar = false;
  graph.set_robot(robot);
  return graph;
}

inline std::map<NodeId, SE3> all_poses(const PoseGraph& graph) {
  std::map<NodeId, SE3> poses;
  for (const auto& [id, at] : graph.nodes_after({}, graph.n_nodes())) poses[id] = at.T_map_base;
  return poses;
}

}  // namespace fusion_slam
