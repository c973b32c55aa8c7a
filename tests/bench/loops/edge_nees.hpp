// How honest the edges' covariances are: their errors against the true poses, squared, in units of
// the covariance (NEES). Right is 3 for x, y, yaw; less is modest, more is boastful.
#pragma once

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <map>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>

#include "libs/graph/edge_noise.hpp"
#include "services/pose_graph/graph_types.hpp"

namespace fusion_slam {

using TruePoses = std::map<std::int64_t, SE3>;  // T_world_base by utime

inline std::optional<SE3> true_pose(const TruePoses& truth, std::int64_t utime_us) {
  const auto after = truth.lower_bound(utime_us);
  if (after == truth.end() || (after == truth.begin() && after->first != utime_us))
    return std::nullopt;
  if (after->first == utime_us) return after->second;
  const auto before = std::prev(after);
  if (after->first - before->first > 200'000) return std::nullopt;
  return interpolate(before->second, after->second,
                     static_cast<double>(utime_us - before->first) /
                         static_cast<double>(after->first - before->first));
}

inline double planar_nees(const Vector6d& error, const Matrix6d& covariance) {
  const int index[3] = {0, 1, 5};
  Eigen::Vector3d e;
  Eigen::Matrix3d c;
  for (int i = 0; i < 3; ++i) {
    e[i] = error[index[i]];
    for (int j = 0; j < 3; ++j) c(i, j) = covariance(index[i], index[j]);
  }
  return e.dot(c.ldlt().solve(e));
}

// One line a kind of edge: as the sensor said, and as the graph believes it.
inline void say_nees(const GraphNodes& nodes, const std::vector<GraphEdge>& edges,
                     const TruePoses& truth, bool planar) {
  static constexpr const char* kNames[] = {"visual",  "lidar",        "tie",        "odometry",
                                           "restart", "loop, visual", "loop, lidar"};
  struct Sum {
    std::vector<double> said, believed;
    double m2 = 0.0, rad2 = 0.0;
  };
  std::map<int, Sum> sums;
  for (const GraphEdge& edge : edges) {
    const auto from = true_pose(truth, nodes.at(edge.from).utime_us);
    const auto to = true_pose(truth, nodes.at(edge.to).utime_us);
    if (!from || !to) continue;
    const Vector6d error = local(edge.T_from_to, from->inverse() * *to);
    Sum& sum = sums[static_cast<int>(edge.kind) +
                    (edge.kind == EdgeKind::kLoop && edge.to.kind == NodeKind::kLidar ? 1 : 0)];
    sum.said.push_back(planar_nees(error, edge.covariance));
    sum.believed.push_back(planar_nees(error, effective_covariance({}, edge, planar)));
    sum.m2 += error.head<2>().squaredNorm();
    sum.rad2 += error[5] * error[5];
  }
  const auto mean_without_worst = [](std::vector<double>* v) {  // 1 % are blunders, not noise
    std::sort(v->begin(), v->end());
    v->resize(std::max<std::size_t>(1, v->size() * 99 / 100));
    double sum = 0.0;
    for (const double x : *v) sum += x;
    return sum / static_cast<double>(v->size());
  };
  for (auto& [kind, sum] : sums) {
    const auto n = static_cast<double>(sum.said.size());
    const auto beyond = std::count_if(sum.believed.begin(), sum.believed.end(),
                                      [](double x) { return x > 16.3; });  // 99.9 %, 3 freedoms
    const double said = mean_without_worst(&sum.said);
    const double believed = mean_without_worst(&sum.believed);
    std::printf(
        "edges %-13s %5.0f, rms error %.4f m %.3f deg, NEES as said %6.2f (median %.2f), as "
        "believed "
        "%.2f (median %.2f), beyond 99.9 %%: %ld\n",
        kNames[kind], n, std::sqrt(sum.m2 / n), std::sqrt(sum.rad2 / n) * 180.0 / M_PI, said,
        sum.said[sum.said.size() / 2], believed, sum.believed[sum.believed.size() / 2],
        static_cast<long>(beyond));
  }
}

// The same of chains of so many edges from one keyframe (LiDAR node) to the next: a bias adds up
// along the way, noise averages out.
inline void say_chain_nees(const GraphNodes& nodes, const std::vector<GraphEdge>& edges,
                           const TruePoses& truth, bool planar, EdgeKind kind) {
  std::map<NodeId, const GraphEdge*> next;
  for (const GraphEdge& edge : edges)
    if (edge.kind == kind && edge.from.kind == edge.to.kind) next[edge.from] = &edge;
  for (const int length : {1, 5, 20, 50}) {
    std::vector<double> said, believed;
    for (const auto& [start, first] : next) {
      NodeId at = start;
      SE3 T = SE3::Identity();
      Matrix6d as_said = Matrix6d::Zero(), as_believed = Matrix6d::Zero();
      int n = 0;
      for (auto it = next.find(at); it != next.end() && n < length; it = next.find(at), ++n) {
        const GraphEdge& edge = *it->second;
        as_said = chained_covariance(as_said, edge.T_from_to, edge.covariance);
        as_believed =
            chained_covariance(as_believed, edge.T_from_to, effective_covariance({}, edge, planar));
        T = T * edge.T_from_to;
        at = edge.to;
      }
      const auto from = true_pose(truth, nodes.at(start).utime_us);
      const auto to = true_pose(truth, nodes.at(at).utime_us);
      if (n < length || !from || !to) continue;
      const Vector6d error = local(T, from->inverse() * *to);
      said.push_back(planar_nees(error, as_said));
      believed.push_back(planar_nees(error, as_believed));
    }
    if (said.empty()) continue;
    std::sort(said.begin(), said.end());
    std::sort(believed.begin(), believed.end());
    std::printf(
        "chains of %2d %s edges: %zu, NEES median as said %.2f, as believed %.2f, p90 %.2f, %.2f\n",
        length, kind == EdgeKind::kVisual ? "visual" : "lidar", said.size(), said[said.size() / 2],
        believed[believed.size() / 2], said[said.size() * 9 / 10],
        believed[believed.size() * 9 / 10]);
  }
}

}  // namespace fusion_slam
