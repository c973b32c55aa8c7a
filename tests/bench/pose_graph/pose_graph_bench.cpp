// How long the pose graph takes: a robot drives round and round a block; when it comes by again,
// loops close. Says the time of each quick solve and of the global one by the graph's size, in CPU
// time: pose_graph_bench [NODES ...].
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>

#include "services/pose_graph/graph_solver.hpp"

namespace fusion_slam {
namespace {

constexpr int kLap = 400;  // nodes round the block, 0.2 m apart

// Of this process, not of the machine: others may be at work.
double cpu_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void run(int n_nodes) {
  std::mt19937 random(7);
  std::normal_distribution<double> gauss;
  const auto noisy = [&](const SE3& T, double m, double rad) {
    Vector6d xi;
    xi << m * gauss(random), m * gauss(random), 0.0, 0.0, 0.0, rad * gauss(random);
    return retract(T, xi);
  };
  Vector6d variance;
  variance << 1e-5, 1e-5, 1e-6, 1e-6, 1e-6, 1e-6;
  const Matrix6d covariance = variance.asDiagonal();
  const auto id = [](int i) { return NodeId{NodeKind::kLidar, i + 1}; };
  const auto truth = [](int i) {
    const double a = 2.0 * M_PI * i / kLap;
    return from_xyz_rpy(12.7 * std::sin(a), 12.7 - 12.7 * std::cos(a), 0, 0, 0, a);
  };
  GraphNodes nodes;
  std::vector<GraphEdge> edges;
  SE3 T = SE3::Identity();
  for (int i = 0; i < n_nodes; ++i) {
    if (i > 0) {
      const SE3 step = noisy(truth(i - 1).inverse() * truth(i), 0.003, 0.001);
      edges.push_back({EdgeKind::kLidar, id(i - 1), id(i), step, covariance, 1.0});
      T = T * step;
    }
    nodes[id(i)].T_map_base = T;
  }
  for (int i = kLap; i < n_nodes; i += 5)
    edges.push_back({EdgeKind::kLoop, id(i % kLap), id(i),
                     noisy(truth(i % kLap).inverse() * truth(i), 0.01, 0.003), covariance, 1.0});
  SolveOptions options;
  options.planar = true;
  options.anchor = id(0);
  const double before_ms = cpu_ms();
  const SolveReport whole = solve_graph({}, options, &nodes, &edges);
  const double global_ms = cpu_ms() - before_ms;
  // One more loop, 3 cm from where the graph is.
  edges.push_back({EdgeKind::kLoop, id(10), id(n_nodes - 3),
                   SE3(nodes[id(10)].T_map_base.inverse() * nodes[id(n_nodes - 3)].T_map_base *
                       from_xyz_rpy(0.03, 0, 0, 0, 0, 0)),
                   covariance, 1.0});
  options.doubt = false;
  options.max_iterations = PoseGraphConfig().quick_iterations;
  const double start_ms = cpu_ms();
  const SolveReport quick = solve_graph({}, options, &nodes, &edges);
  std::printf(
      "%6d nodes, %6zu edges: quick solve %.1f ms (%d iterations), from scratch %.1f ms (%d)\n",
      n_nodes, edges.size(), cpu_ms() - start_ms, quick.iterations, global_ms, whole.iterations);
}

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  std::vector<int> sizes;
  for (int i = 1; i < argc; ++i) sizes.push_back(std::atoi(argv[i]));
  if (sizes.empty()) sizes = {500, 1000, 2000, 4000};
  for (const int n : sizes) {
    if (n < 20) {
      std::fprintf(stderr, "pose_graph_bench: numbers of nodes, at least 20 each\n");
      return 2;
    }
    fusion_slam::run(n);
  }
  return 0;
}
