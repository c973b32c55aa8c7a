// Global bundle adjustment: all poses of the graph and the points that keyframes saw, at once, with
// the LiDAR's edges and loops in the same equations. Sources: Triggs et al. 2000, "Bundle
// adjustment - a modern synthesis"; Mur-Artal & Tardos 2017, section III-D (after a loop).
#pragma once

#include <string>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "services/pose_graph/graph_solver.hpp"
#include "services/pose_graph/landmark_store.hpp"

namespace fusion_slam {

struct BundleQuestion {
  CameraModel camera;
  SE3 T_base_camera = SE3::Identity();
  LandmarkStore seen;
  std::vector<SamePoints> same;  // of the loops that are believed
};

struct BundleReport {
  bool accepted = false;
  std::string reason;  // why not, or what was gained
  std::size_t landmarks = 0;
  std::size_t views = 0;
  double initial_cost = 0.0;  // robust, of everything
  double final_cost = 0.0;
  int iterations = 0;
  double largest_move_m = 0.0;
};

// When the robust cost of everything falls and no edge that agreed with the graph is contradicted
// by the result (config.bundle.gate_chi2), moves nodes' T_map_base and sets `adjusted` of the edges
// between keyframes that were measured by the camera; else changes nothing. Pure, deterministic,
// one thread.
BundleReport adjust_globally(const PoseGraphConfig& config, const SolveOptions& options,
                             const BundleQuestion& question, GraphNodes* nodes,
                             std::vector<GraphEdge>* edges);

}  // namespace fusion_slam
