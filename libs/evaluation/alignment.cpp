#include "libs/evaluation/alignment.hpp"

#include <algorithm>
#include <limits>

#include <Eigen/SVD>

namespace fusion_slam {
namespace {

// Singular values below this share of the largest are rounding noise.
constexpr double kRankTolerance = 1e-12;

Eigen::Vector3d mean_of(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

std::vector<Eigen::Vector3d> positions_of(const Trajectory& trajectory) {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) positions.push_back(pose.T_world_body.translation());
  return positions;
}

}  // namespace

std::string_view name_of(Alignment alignment) {
  switch (alignment) {
    case Alignment::kNone:
      return "none";
    case Alignment::kOrigin:
      return "origin";
    case Alignment::kSe3:
      return "se3";
    case Alignment::kSim3:
      return "sim3";
  }
  return "";
}

Eigen::Vector3d Similarity::operator*(const Eigen::Vector3d& p_from) const {
  return T_to_from * Eigen::Vector3d(scale * p_from);
}

SE3 Similarity::operator*(const SE3& pose_in_from) const {
  SE3 scaled = pose_in_from;
  scaled.translation() *= scale;
  return T_to_from * scaled;
}

Outcome<Similarity> umeyama(const std::vector<Eigen::Vector3d>& from,
                            const std::vector<Eigen::Vector3d>& to, bool with_scale) {
  if (from.size() < 3) {
    return Outcome<Similarity>::failure("alignment needs at least 3 matched poses, there are " +
                                        std::to_string(from.size()) +
                                        "; try --align origin or none, or a larger --max-diff");
  }
  const auto n = static_cast<double>(from.size());
  const Eigen::Vector3d mean_from = mean_of(from);
  const Eigen::Vector3d mean_to = mean_of(to);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double variance_from = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    covariance += (to[i] - mean_to) * (from[i] - mean_from).transpose();
    variance_from += (from[i] - mean_from).squaredNorm();
  }
  covariance /= n;
  variance_from /= n;

  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d& d = svd.singularValues();
  if (d(1) <= std::max(std::numeric_limits<double>::epsilon(), kRankTolerance * d(0))) {
    return Outcome<Similarity>::failure(
        "the matched positions lie on one line or in one place, so that no rotation aligns them "
        "best; "
        "try --align origin or none");
  }
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) signs.z() = -1.0;

  Similarity S;
  S.T_to_from.linear() = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  if (with_scale) S.scale = d.dot(signs) / variance_from;
  S.T_to_from.translation() = mean_to - S.scale * (S.T_to_from.linear() * mean_from);
  return Outcome<Similarity>::success(S);
}

Outcome<Similarity> find_alignment(const MatchedPoses& matched, Alignment alignment) {
  Similarity S;
  if (alignment == Alignment::kNone) return Outcome<Similarity>::success(S);
  if (alignment == Alignment::kOrigin) {
    S.T_to_from =
        matched.reference.front().T_world_body * matched.estimate.front().T_world_body.inverse();
    return Outcome<Similarity>::success(S);
  }
  return umeyama(positions_of(matched.estimate), positions_of(matched.reference),
                 alignment == Alignment::kSim3);
}

Trajectory transform(const Similarity& S, const Trajectory& trajectory) {
  Trajectory moved = trajectory;
  for (StampedPose& pose : moved) pose.T_world_body = S * pose.T_world_body;
  return moved;
}

}  // namespace fusion_slam
