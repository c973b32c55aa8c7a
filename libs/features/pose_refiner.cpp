#include "libs/features/pose_refiner.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace fusion_slam {
namespace {

constexpr double kNearest_m = 0.05;

struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double cost = 0.0;
};

double gate(const Correspondence& match, const RefineConfig& config) {
  return match.depth_m > 0.0 ? config.gate_3d : config.gate_2d;
}

// Huber's loss on the chi square r . r when robust (kernel width: the gate).
void add(const Eigen::Vector3d& r, const ResidualJacobian& J, double limit, bool robust,
         NormalEquations* sum) {
  const double chi2 = r.squaredNorm();
  const bool outside = robust && chi2 > limit;
  const double weight = outside ? std::sqrt(limit / chi2) : 1.0;
  sum->cost += outside ? 2.0 * std::sqrt(limit * chi2) - limit : chi2;
  sum->H.noalias() += weight * J.transpose() * J;
  sum->b.noalias() += weight * J.transpose() * r;
}

// Sums over the matches in use, and the planar prior.
NormalEquations accumulate(const CameraModel& camera, const std::vector<Correspondence>& matches,
                           const std::vector<bool>& use, const SE3& T, const RefineConfig& config,
                           bool robust) {
  NormalEquations sum;
  Eigen::Vector3d r;
  ResidualJacobian J;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (!use[i]) continue;
    const double limit = gate(matches[i], config);
    if (!pose_residual(camera, matches[i], T, &r, &J)) {
      sum.cost += 100.0 * limit;  // a step that puts points behind the camera is a bad step
      continue;
    }
    add(r, J, limit, robust, &sum);
  }
  if (config.prior) {
    const Vector6d apart = local(config.prior->T_reference_camera, T);
    const Vector6d weighted = config.prior->information * apart;
    sum.cost += apart.dot(weighted);
    sum.H += config.prior->information;
    sum.b += weighted;
  }
  if (config.planar) {
    r = planar_prior_residual(*config.planar, T, &J);
    add(r, J, config.gate_3d, true, &sum);
  }
  return sum;
}

// Levenberg-Marquardt from T over the matches in use.
SE3 minimise(const CameraModel& camera, const std::vector<Correspondence>& matches,
             const std::vector<bool>& use, SE3 T, const RefineConfig& config, bool robust) {
  double lambda = 1e-4;
  NormalEquations now = accumulate(camera, matches, use, T, config, robust);
  for (int i = 0; i < config.iterations; ++i) {
    Matrix6d damped = now.H;
    damped.diagonal() *= 1.0 + lambda;
    damped.diagonal().array() += 1e-9;
    const Vector6d step = damped.ldlt().solve(-now.b);
    if (!step.allFinite()) break;
    const SE3 candidate = retract(T, step);
    const NormalEquations next = accumulate(camera, matches, use, candidate, config, robust);
    if (next.cost < now.cost) {
      const bool done = step.norm() < 1e-6;
      T = candidate;
      now = next;
      lambda *= 0.1;
      if (done) break;
    } else {
      if (step.norm() < 1e-8) break;
      lambda *= 10.0;
    }
  }
  return T;
}

}  // namespace

bool pose_residual(const CameraModel& camera, const Correspondence& match,
                   const SE3& T_reference_camera, Eigen::Vector3d* residual,
                   ResidualJacobian* jacobian, Eigen::Matrix3d* by_point) {
  const Eigen::Vector3d p = T_reference_camera.linear().transpose() *
                            (match.p_reference - T_reference_camera.translation());
  if (p.z() < kNearest_m) return false;
  const double inv_z = 1.0 / p.z();
  const bool has_depth = match.depth_m > 0.0;
  *residual << (camera.project(p) - match.pixel) / match.pixel_sigma,
      has_depth ? (p.z() - match.depth_m) / match.depth_sigma_m : 0.0;
  if (jacobian == nullptr && by_point == nullptr) return true;
  Eigen::Matrix3d by_p;  // of the residual by the point in the camera
  by_p << camera.fx_px * inv_z, 0.0, -camera.fx_px * p.x() * inv_z * inv_z,  //
      0.0, camera.fy_px * inv_z, -camera.fy_px * p.y() * inv_z * inv_z,      //
      0.0, 0.0, 1.0;
  by_p.topRows<2>() /= match.pixel_sigma;
  by_p.row(2) *= has_depth ? 1.0 / match.depth_sigma_m : 0.0;
  if (by_point != nullptr) *by_point = by_p * T_reference_camera.linear().transpose();
  if (jacobian == nullptr) return true;
  // The camera moves by (t, w) in its own axes: p becomes Exp(-w) (p - t).
  jacobian->leftCols<3>() = -by_p;
  jacobian->rightCols<3>() = by_p * skew(p);
  return true;
}

RefinedPose refine_pose(const CameraModel& camera, const std::vector<Correspondence>& matches,
                        const SE3& guess_T_reference_camera, const RefineConfig& config) {
  RefinedPose result;
  result.T_reference_camera = guess_T_reference_camera;
  result.inlier.assign(matches.size(), true);
  double chi2_sum = 0.0;
  int freedoms = -6;
  for (int round = 0; round < config.rounds; ++round) {
    const bool robust = round + 1 < config.rounds;  // the last round has only inliers left
    result.T_reference_camera =
        minimise(camera, matches, result.inlier, result.T_reference_camera, config, robust);
    chi2_sum = 0.0;
    freedoms = -6;
    result.n_inliers = 0;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      Eigen::Vector3d r;
      const bool ahead = pose_residual(camera, matches[i], result.T_reference_camera, &r, nullptr);
      result.inlier[i] = ahead && r.squaredNorm() <= gate(matches[i], config);
      if (!result.inlier[i]) continue;
      ++result.n_inliers;
      chi2_sum += r.squaredNorm();
      freedoms += matches[i].depth_m > 0.0 ? 3 : 2;
    }
    if (result.n_inliers < 4 && !config.prior) break;
  }
  if (result.n_inliers < 4 && !config.prior) return result;
  result.mean_chi2 = chi2_sum / std::max(1, freedoms);
  const NormalEquations last =
      accumulate(camera, matches, result.inlier, result.T_reference_camera, config, false);
  const Eigen::LDLT<Matrix6d> ldlt(last.H);
  if (ldlt.info() == Eigen::Success && ldlt.isPositive())
    result.covariance = ldlt.solve(Matrix6d::Identity()) * std::max(1.0, result.mean_chi2);
  if (!result.covariance.allFinite()) result.covariance = Matrix6d::Identity();
  return result;
}

Matrix6d in_base_axes(const Matrix6d& covariance_camera, const SE3& T_base_camera) {
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = T_base_camera.linear();
  adjoint.topRightCorner<3, 3>() = skew(T_base_camera.translation()) * T_base_camera.linear();
  adjoint.bottomRightCorner<3, 3>() = T_base_camera.linear();
  return adjoint * covariance_camera * adjoint.transpose();
}

}  // namespace fusion_slam
