// A camera that drives a circle in a room of points, what it sees of them, and a chain of edges
// that has drifted.
#pragma once

#include <random>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "services/pose_graph/global_bundle.hpp"

namespace fusion_slam {

struct MadeUpRoom {
  BundleQuestion question;
  std::vector<SE3> truth;  // T_map_base of keyframe i + 1
  GraphNodes nodes;        // dead reckoning
  std::vector<GraphEdge> edges;
  std::vector<std::vector<SeenFeature>> seen;  // by keyframe, as in question.seen

  static NodeId id(std::size_t keyframe) {
    return {NodeKind::kKeyframe, static_cast<std::int64_t>(keyframe) + 1};
  }

  // Points are known by one name all the way: what is seen again closes the circle.
  MadeUpRoom(std::size_t n_keyframes, int n_points, double drift_m, double drift_rad,
             unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> gauss;
    std::uniform_real_distribution<double> u(-1.0, 1.0);
    question.T_base_camera = from_xyz_rpy(0.1, 0.02, 0.35, 0, 0, 0);
    question.T_base_camera.linear() = optical_to_body();
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < n_points; ++i) {  // on four walls
      const double along = 4.0 * u(random), z = 1.2 + 1.2 * u(random);
      const Eigen::Vector3d p(i % 2 == 0 ? along : (i % 4 == 1 ? 4.0 : -4.0),
                              i % 2 == 0 ? (i % 4 == 0 ? 4.0 : -4.0) : along, z);
      points.push_back(p);
    }
    const double step_rad = 2.0 * M_PI / static_cast<double>(n_keyframes - 4);  // a bit overlaps
    for (std::size_t k = 0; k < n_keyframes; ++k) {
      const double a = step_rad * static_cast<double>(k);
      const SE3 T = from_xyz_rpy(1.5 * std::sin(a), 1.5 * (1.0 - std::cos(a)), 0, 0, 0, a);
      truth.push_back(T);
      if (k > 0) {
        Vector6d noise = Vector6d::Zero();
        noise << drift_m * gauss(random), drift_m * gauss(random), 0.0, 0.0, 0.0,
            drift_rad * (1.0 + gauss(random));
        const SE3 step = retract(SE3(truth[k - 1].inverse() * T), noise);
        Vector6d variance;
        variance << Eigen::Vector3d::Constant(drift_m * drift_m + 1e-8),
            Eigen::Vector3d::Constant(2.0 * drift_rad * drift_rad + 1e-8);
        edges.push_back({EdgeKind::kVisual, id(k - 1), id(k), step, variance.asDiagonal(), 1.0});
        nodes[id(k)].T_map_base = nodes[id(k - 1)].T_map_base * step;
      } else {
        nodes[id(0)].T_map_base = T;
      }
      seen.push_back(seen_from(T, points, &random));
      question.seen.add(id(k).id, seen.back());
    }
  }

  double worst_m(const GraphNodes& of) const {
    double worst = 0.0;
    for (std::size_t k = 0; k < truth.size(); ++k)
      worst =
          std::max(worst, (of.at(id(k)).T_map_base.translation() - truth[k].translation()).norm());
    return worst;
  }

 private:
  std::vector<SeenFeature> seen_from(const SE3& T_map_base,
                                     const std::vector<Eigen::Vector3d>& points,
                                     std::mt19937* random) const {
    std::normal_distribution<double> gauss;
    std::vector<SeenFeature> seen;
    const SE3 T_camera_map = (T_map_base * question.T_base_camera).inverse();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d p = T_camera_map * points[i];
      if (p.z() < 0.5) continue;
      const Eigen::Vector2d pixel = question.camera.project(p);
      if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > 639 || pixel.y() > 479) continue;
      SeenFeature f;
      f.landmark = static_cast<std::int64_t>(i) + 1;
      f.index = static_cast<int>(seen.size());
      f.u_px = static_cast<float>(pixel.x() + 0.5 * gauss(*random));
      f.v_px = static_cast<float>(pixel.y() + 0.5 * gauss(*random));
      const double sigma = question.camera.depth_sigma(p.z());
      if (i % 5 != 0) f.depth_m = static_cast<float>(p.z() + sigma * gauss(*random));
      f.depth_sigma_m = static_cast<float>(sigma);
      seen.push_back(f);
    }
    return seen;
  }
};

}  // namespace fusion_slam
