#include "services/pose_graph/sensor_agreement.hpp"

#include <Eigen/Cholesky>

namespace fusion_slam {
namespace {

// x, y, yaw of a covariance of a pose.
Eigen::Matrix3d in_plane(const Matrix6d& covariance) {
  constexpr int kPlane[] = {0, 1, 5};
  Eigen::Matrix3d part;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      part(row, column) = covariance(kPlane[row], kPlane[column]);
  return part;
}

}  // namespace

std::optional<Matrix6d> doubted_covariance(const EdgeNoiseConfig& noise, const GraphEdge& visual,
                                           const LidarSays& lidar, bool planar, double gate_chi2) {
  const Vector6d apart = local(visual.T_from_to, lidar.T_from_to);
  const Eigen::Vector3d error(apart(0), apart(1), apart(5));
  const Eigen::Matrix3d covariance = in_plane(effective_covariance(noise, visual, planar)) +
                                     in_plane(noise.lidar_optimism * lidar.covariance);
  if (error.dot(covariance.ldlt().solve(error)) <= gate_chi2) return std::nullopt;
  Matrix6d grown = visual.covariance;
  grown.diagonal().head<3>().array() += error.head<2>().squaredNorm();
  grown.diagonal().tail<3>().array() += error.z() * error.z();
  return grown;
}

}  // namespace fusion_slam
