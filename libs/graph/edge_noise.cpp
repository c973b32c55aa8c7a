#include "libs/graph/edge_noise.hpp"

namespace fusion_slam {

Matrix6d effective_covariance(const EdgeNoiseConfig& config, const GraphEdge& edge, bool planar) {
  Matrix6d covariance = edge.covariance;
  if (edge.kind == EdgeKind::kLidar || edge.kind == EdgeKind::kTie)
    covariance *= config.lidar_optimism;
  else if (edge.kind != EdgeKind::kLoop)
    covariance *= config.visual_optimism;
  else if (edge.to.kind == NodeKind::kLidar)
    covariance *= config.lidar_loop_optimism;
  if (edge.kind == EdgeKind::kLidar || edge.kind == EdgeKind::kTie ||
      edge.kind == EdgeKind::kOdometry) {
    const double z = planar ? config.lidar_planar_z_m : config.lidar_free_z_m;
    const double tilt = planar ? config.lidar_planar_tilt_rad : config.lidar_free_tilt_rad;
    for (const int unseen : {2, 3, 4}) {
      covariance.row(unseen).setZero();
      covariance.col(unseen).setZero();
      covariance(unseen, unseen) = unseen == 2 ? z * z : tilt * tilt;
    }
  }
  const double t = config.floor_translation_m;
  const double r = config.floor_rotation_rad;
  covariance.diagonal().head<3>().array() += t * t;
  covariance.diagonal().tail<3>().array() += r * r;
  return covariance;
}

Matrix6d adjoint(const SE3& T_a_b) {
  Matrix6d ad = Matrix6d::Zero();
  ad.topLeftCorner<3, 3>() = T_a_b.linear();
  ad.topRightCorner<3, 3>() = skew(T_a_b.translation()) * T_a_b.linear();
  ad.bottomRightCorner<3, 3>() = T_a_b.linear();
  return ad;
}

Matrix6d chained_covariance(const Matrix6d& of_a_b, const SE3& T_b_c, const Matrix6d& of_b_c) {
  const Matrix6d ad = adjoint(T_b_c.inverse());
  return ad * of_a_b * ad.transpose() + of_b_c;
}

Matrix6d inverse_covariance(const Matrix6d& of_a_b, const SE3& T_a_b) {
  const Matrix6d ad = adjoint(T_a_b);
  return ad * of_a_b * ad.transpose();
}

}  // namespace fusion_slam
