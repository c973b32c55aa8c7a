#include "services/visual_odometry/local_bundle_adjustment.hpp"

#include <algorithm>
#include <map>
#include <set>

#include <Eigen/Eigenvalues>
#include <ceres/loss_function.h>
#include <ceres/ordered_groups.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include "libs/features/pose_refiner.hpp"
#include "libs/pose_manifold/pose_manifold.hpp"
#include "libs/pose_manifold/relative_pose_cost.hpp"
#include "services/visual_odometry/bundle_costs.hpp"
#include "services/visual_odometry/correspondences.hpp"

namespace fusion_slam {
namespace {

struct Link {
  std::int64_t keyframe = 0;
  std::int64_t landmark = 0;
  Correspondence seen;
};

// Blocks by id, laid out in one piece in the order of the ids: Ceres orders blocks by their
// address.
template <class Block>
struct Blocks {
  std::map<std::int64_t, std::size_t> index;
  std::vector<Block> blocks;

  bool has(std::int64_t id) const { return index.count(id) > 0; }
  Block& at(std::int64_t id) { return blocks[index.at(id)]; }
};

template <class Block>
Blocks<Block> in_one_piece(const std::map<std::int64_t, Block>& scattered) {
  Blocks<Block> result;
  result.blocks.reserve(scattered.size());
  for (const auto& [id, block] : scattered) {
    result.index.emplace_hint(result.index.end(), id, result.blocks.size());
    result.blocks.push_back(block);
  }
  return result;
}

struct Bundle {
  Blocks<PoseBlock> poses;               // moving ones and those that hold
  Blocks<std::array<double, 3>> points;  // seen at least twice within the map
  std::vector<Link> links;
  std::vector<std::int64_t> tied;  // moving keyframes whose tie counts
  std::set<std::int64_t> fixed;
};

std::vector<Link> links_of(std::int64_t id, const std::vector<double>& scales,
                           const VisualOdometryConfig& config, const VisualMap& map) {
  std::vector<Link> links;
  for (const Observation& o : map.landmark(id)->observations) {
    const MapKeyframe* keyframe = map.keyframe(o.keyframe);
    if (keyframe == nullptr) continue;
    const Feature& f = keyframe->features->features[o.feature];
    links.push_back(
        {o.keyframe, id,
         make_correspondence(Eigen::Vector3d::Zero(), f, config.pixel_sigma * scales[f.octave])});
  }
  return links;
}

Bundle gather(const std::vector<std::int64_t>& moving, const std::vector<double>& scales,
              const VisualOdometryConfig& config, const VisualMap& map) {
  Bundle bundle;
  std::set<std::int64_t> seen;
  for (const std::int64_t id : moving)
    if (const MapKeyframe* keyframe = map.keyframe(id))
      seen.insert(keyframe->landmark_of_feature.begin(), keyframe->landmark_of_feature.end());
  std::map<std::int64_t, PoseBlock> poses;
  std::map<std::int64_t, std::array<double, 3>> points;
  for (const std::int64_t id : seen) {
    const Landmark* landmark = id == 0 ? nullptr : map.landmark(id);
    if (landmark == nullptr || landmark->observations.size() < 2) continue;
    const std::vector<Link> links = links_of(id, scales, config, map);
    if (links.size() < 2) continue;
    points[id] = {landmark->p_odom.x(), landmark->p_odom.y(), landmark->p_odom.z()};
    for (const Link& link : links) {
      poses.emplace(link.keyframe, to_block(map.keyframe(link.keyframe)->T_odom_camera));
      if (!std::binary_search(moving.begin(), moving.end(), link.keyframe))
        bundle.fixed.insert(link.keyframe);
    }
    bundle.links.insert(bundle.links.end(), links.begin(), links.end());
  }
  for (const std::int64_t id : moving) {
    const MapKeyframe* keyframe = map.keyframe(id);
    const MapKeyframe* earlier =
        keyframe == nullptr ? nullptr : map.keyframe(keyframe->tie.keyframe);
    if (earlier == nullptr) continue;
    poses.emplace(id, to_block(keyframe->T_odom_camera));
    poses.emplace(earlier->id, to_block(earlier->T_odom_camera));
    if (!std::binary_search(moving.begin(), moving.end(), earlier->id))
      bundle.fixed.insert(earlier->id);
    bundle.tied.push_back(id);
  }
  if (bundle.fixed.empty() && !poses.empty()) bundle.fixed.insert(poses.begin()->first);
  bundle.poses = in_one_piece(poses);
  bundle.points = in_one_piece(points);
  return bundle;
}

ceres::Solver::Options solver_options(const VisualOdometryConfig& config) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = config.bundle_iterations;
  options.function_tolerance = 1e-4;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  return options;
}

// S with S^T S = information, which may be singular.
Matrix6d sqrt_of(const Matrix6d& information) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(information);
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
}

void solve(const CameraModel& camera, const VisualOdometryConfig& config, const VisualMap& map,
           Bundle* bundle, BundleResult* result) {
  ceres::Problem::Options owns;
  PoseManifold manifold;
  ceres::HuberLoss with_depth(std::sqrt(config.refine.gate_3d));
  ceres::HuberLoss bearing_only(std::sqrt(config.refine.gate_2d));
  ceres::HuberLoss of_tie(std::sqrt(config.bundle_tie_gate));
  owns.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  owns.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(owns);
  ceres::Solver::Options options = solver_options(config);
  for (const auto& [id, i] : bundle->poses.index) {
    PoseBlock& block = bundle->poses.blocks[i];
    problem.AddParameterBlock(block.data(), 7, &manifold);
    options.linear_solver_ordering->AddElementToGroup(block.data(), 1);
    if (bundle->fixed.count(id) > 0)
      problem.SetParameterBlockConstant(block.data());
    else if (config.refine.planar)
      problem.AddResidualBlock(new PlanarPriorCost(*config.refine.planar), &with_depth,
                               block.data());
  }
  for (auto& block : bundle->points.blocks) {
    problem.AddParameterBlock(block.data(), 3);
    options.linear_solver_ordering->AddElementToGroup(block.data(), 0);
  }
  for (const Link& link : bundle->links)
    problem.AddResidualBlock(new ObservationCost(camera, link.seen),
                             link.seen.depth_m > 0.0 ? &with_depth : &bearing_only,
                             bundle->poses.at(link.keyframe).data(),
                             bundle->points.at(link.landmark).data());
  for (const std::int64_t id : bundle->tied) {
    const SurfaceTie& tie = map.keyframe(id)->tie;
    problem.AddResidualBlock(new RelativePoseCost(tie.T_earlier_camera, sqrt_of(tie.information)),
                             &of_tie, bundle->poses.at(tie.keyframe).data(),
                             bundle->poses.at(id).data());
  }
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  result->initial_cost = summary.initial_cost;
  result->final_cost = summary.final_cost;
}

// Landmarks that only one keyframe sees go where it goes.
void carry_along(const MapKeyframe& keyframe, const SE3& T_new_camera, const Bundle& bundle,
                 VisualMap* map) {
  const SE3 T_new_old = T_new_camera * keyframe.T_odom_camera.inverse();
  for (const std::int64_t id : keyframe.landmark_of_feature) {
    Landmark* landmark = id == 0 ? nullptr : map->landmark(id);
    if (landmark == nullptr || bundle.points.has(id)) continue;
    if (landmark->observations.front().keyframe == keyframe.id)
      landmark->p_odom = T_new_old * landmark->p_odom;
  }
}

}  // namespace

BundleResult adjust_bundle(const CameraModel& camera, const std::vector<std::int64_t>& moving,
                           const std::vector<double>& scale_of_octave,
                           const VisualOdometryConfig& config, VisualMap* map) {
  BundleResult result;
  Bundle bundle = gather(moving, scale_of_octave, config, *map);
  result.n_landmarks = static_cast<int>(bundle.points.blocks.size());
  result.n_observations = static_cast<int>(bundle.links.size());
  if (bundle.links.empty() || bundle.poses.blocks.size() < 2) return result;
  solve(camera, config, *map, &bundle, &result);

  for (const auto& [id, i] : bundle.poses.index) {
    if (bundle.fixed.count(id) > 0) continue;
    const SE3 T_odom_camera = from_block(bundle.poses.blocks[i].data());
    MapKeyframe* keyframe = map->keyframe(id);
    carry_along(*keyframe, T_odom_camera, bundle, map);
    keyframe->T_odom_camera = T_odom_camera;
    ++result.n_poses;
  }
  for (const auto& [id, i] : bundle.points.index)
    map->landmark(id)->p_odom = Eigen::Map<const Eigen::Vector3d>(bundle.points.blocks[i].data());
  for (const Link& link : bundle.links) {
    const Landmark* landmark = map->landmark(link.landmark);
    if (landmark == nullptr) continue;  // its last observation has just gone
    Correspondence seen = link.seen;
    seen.p_reference = landmark->p_odom;
    Eigen::Vector3d residual;
    const double gate = seen.depth_m > 0.0 ? config.bundle_outlier_3d : config.bundle_outlier_2d;
    if (pose_residual(camera, seen, map->keyframe(link.keyframe)->T_odom_camera, &residual,
                      nullptr) &&
        residual.squaredNorm() <= gate)
      continue;
    map->unlink(link.landmark, link.keyframe);
    ++result.n_outliers;
  }
  return result;
}

}  // namespace fusion_slam
