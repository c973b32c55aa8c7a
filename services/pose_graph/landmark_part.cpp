#include "services/pose_graph/landmark_part.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Cholesky>

#include "libs/features/pose_refiner.hpp"
#include "libs/graph/edge_noise.hpp"

namespace fusion_slam {
namespace {

constexpr double kBehind = 1000.0;  // squared error of a point behind the camera
constexpr int kSettleSteps = 4;

// Cauchy 1/2 c^2 log(1 + s / c^2), and what it weighs.
double loss(double s, double c2) { return c2 * std::log1p(s / c2); }
double weight(double s, double c2) { return 1.0 / (1.0 + s / c2); }

}  // namespace

LandmarkPart::LandmarkPart(const CameraModel& camera, const SE3& T_base_camera,
                           const LandmarkNoise& noise)
    : camera_(camera),
      T_base_camera_(T_base_camera),
      camera_by_base_(adjoint(T_base_camera.inverse())),
      noise_(noise) {}

void LandmarkPart::add(const Eigen::Vector3d& p_map_m, std::vector<LandmarkView> views) {
  Landmark landmark;
  landmark.p_map_m = landmark.before_m = p_map_m;
  n_views_ += views.size();
  landmark.views = std::move(views);
  landmark.W.resize(landmark.views.size());
  landmarks_.push_back(std::move(landmark));
}

void LandmarkPart::make_pattern(int n_variables) {
  std::map<std::pair<int, int>, int> index;
  const auto key = [](const LandmarkView& a, const LandmarkView& b) {
    return std::make_pair(std::min(a.variable, b.variable), std::max(a.variable, b.variable));
  };
  for (const Landmark& landmark : landmarks_)
    for (std::size_t a = 0; a < landmark.views.size(); ++a)
      for (std::size_t b = a; b < landmark.views.size(); ++b)
        if (landmark.views[a].variable >= 0 && landmark.views[b].variable >= 0)
          index.emplace(key(landmark.views[a], landmark.views[b]), 0);
  for (auto& [pair, block] : index) {
    block = static_cast<int>(pairs_.size());
    pairs_.push_back(pair);
  }
  for (Landmark& landmark : landmarks_)
    for (std::size_t a = 0; a < landmark.views.size(); ++a)
      for (std::size_t b = a; b < landmark.views.size(); ++b) {
        const bool moves = landmark.views[a].variable >= 0 && landmark.views[b].variable >= 0;
        landmark.pair_of.push_back(moves ? index.at(key(landmark.views[a], landmark.views[b]))
                                         : -1);
      }
  blocks_.resize(pairs_.size());
  gradient_.resize(static_cast<std::size_t>(n_variables));
}

// False: behind the camera.
bool LandmarkPart::residual(const Landmark& landmark, const LandmarkView& view, const Poses& poses,
                            Eigen::Vector3d* r, Eigen::Matrix<double, 3, 6>* by_pose,
                            Eigen::Matrix3d* by_point) const {
  const SE3& T_map_base =
      view.variable >= 0 ? poses[static_cast<std::size_t>(view.variable)] : view.T_map_base;
  Correspondence seen = view.seen;
  seen.p_reference = landmark.p_map_m;
  return pose_residual(camera_, seen, T_map_base * T_base_camera_, r, by_pose, by_point);
}

double LandmarkPart::doubt(const LandmarkView& view) const {
  return view.seen.depth_m > 0.0 ? noise_.doubt_3d : noise_.doubt_2d;
}

double LandmarkPart::cost_of(const Landmark& landmark, const Poses& poses) const {
  double sum = 0.0;
  Eigen::Vector3d r;
  for (const LandmarkView& view : landmark.views) {
    const bool ahead = residual(landmark, view, poses, &r, nullptr, nullptr);
    sum += loss(ahead ? r.squaredNorm() : kBehind, doubt(view));
  }
  return 0.5 * sum / noise_.optimism;
}

double LandmarkPart::cost(const Poses& poses) const {
  double sum = 0.0;
  for (const Landmark& landmark : landmarks_) sum += cost_of(landmark, poses);
  return sum;
}

void LandmarkPart::settle(const Poses& poses) {
  for (Landmark& landmark : landmarks_)
    for (int i = 0; i < kSettleSteps; ++i) settle_one(poses, &landmark);
}

void LandmarkPart::settle_one(const Poses& poses, Landmark* landmark) const {
  Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  for (const LandmarkView& view : landmark->views) {
    Eigen::Vector3d r;
    Eigen::Matrix3d by_point;
    if (!residual(*landmark, view, poses, &r, nullptr, &by_point)) continue;
    const double w = weight(r.squaredNorm(), doubt(view)) / noise_.optimism;
    V.noalias() += w * (by_point.transpose() * by_point);
    g.noalias() += w * (by_point.transpose() * r);
  }
  V.diagonal().array() += 1e-9 * V.trace() + 1e-12;
  Eigen::Vector3d step = V.llt().solve(g);
  const double now = cost_of(*landmark, poses);
  const Eigen::Vector3d start_m = landmark->p_map_m;
  for (int halved = 0; halved < 4; ++halved, step *= 0.5) {
    landmark->p_map_m = start_m - step;
    if (cost_of(*landmark, poses) <= now) return;
  }
  landmark->p_map_m = start_m;
}

int LandmarkPart::n_doubted(const Poses& poses) const {
  int n = 0;
  Eigen::Vector3d r;
  for (const Landmark& landmark : landmarks_)
    for (const LandmarkView& view : landmark.views)
      n += !residual(landmark, view, poses, &r, nullptr, nullptr) || r.squaredNorm() > doubt(view)
               ? 1
               : 0;
  return n;
}

void LandmarkPart::linearise(const Poses& poses) {
  for (Matrix6d& block : blocks_) block.setZero();
  for (Vector6d& g : gradient_) g.setZero();
  for (Landmark& landmark : landmarks_) eliminate(poses, &landmark);
}

// With U, V, W the blocks of poses, point and both: U - W V^-1 W^T, and g_pose - W V^-1 g_point.
void LandmarkPart::eliminate(const Poses& poses, Landmark* landmark) {
  Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
  landmark->g.setZero();
  const std::size_t n = landmark->views.size();
  std::size_t pair = 0;
  for (std::size_t a = 0; a < n; pair += n - a, ++a) {
    const LandmarkView& view = landmark->views[a];
    Eigen::Vector3d r;
    Eigen::Matrix<double, 3, 6> by_camera;
    Eigen::Matrix3d by_point;
    landmark->W[a].setZero();
    if (!residual(*landmark, view, poses, &r, &by_camera, &by_point)) continue;
    const double w = weight(r.squaredNorm(), doubt(view)) / noise_.optimism;
    V.noalias() += w * (by_point.transpose() * by_point);
    landmark->g.noalias() += w * (by_point.transpose() * r);
    if (view.variable < 0) continue;
    const Eigen::Matrix<double, 3, 6> J = by_camera * camera_by_base_;
    landmark->W[a].noalias() = w * (J.transpose() * by_point);
    blocks_[static_cast<std::size_t>(landmark->pair_of[pair])].noalias() += w * (J.transpose() * J);
    gradient_[static_cast<std::size_t>(view.variable)].noalias() += w * (J.transpose() * r);
  }
  const double trace = V.trace();
  if (!(trace > 0.0)) {
    landmark->V_inverse.setZero();
    return;
  }
  V.diagonal().array() += 1e-9 * trace;
  landmark->V_inverse = V.llt().solve(Eigen::Matrix3d::Identity());
  pair = 0;
  for (std::size_t a = 0; a < n; ++a) {
    const int i = landmark->views[a].variable;
    const Matrix63d WV = landmark->W[a] * landmark->V_inverse;
    if (i >= 0) gradient_[static_cast<std::size_t>(i)].noalias() -= WV * landmark->g;
    for (std::size_t b = a; b < n; ++b, ++pair) {
      if (landmark->pair_of[pair] < 0) continue;
      Matrix6d& block = blocks_[static_cast<std::size_t>(landmark->pair_of[pair])];
      if (i <= landmark->views[b].variable)
        block.noalias() -= WV * landmark->W[b].transpose();
      else
        block.noalias() -= landmark->W[b] * WV.transpose();
    }
  }
}

void LandmarkPart::step(const std::vector<Vector6d>& pose_steps) {
  for (Landmark& landmark : landmarks_) {
    Eigen::Vector3d g = landmark.g;
    for (std::size_t a = 0; a < landmark.views.size(); ++a)
      if (landmark.views[a].variable >= 0)
        g.noalias() += landmark.W[a].transpose() *
                       pose_steps[static_cast<std::size_t>(landmark.views[a].variable)];
    landmark.before_m = landmark.p_map_m;
    landmark.p_map_m -= landmark.V_inverse * g;
  }
}

void LandmarkPart::drop() {
  for (Landmark& landmark : landmarks_) landmark.p_map_m = landmark.before_m;
}

}  // namespace fusion_slam
