// A rigid motion as a parameter block of Ceres: what every adjustment of poses shares.
#pragma once

#include <array>

#include <ceres/manifold.h>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

// x, y, z (m), then the quaternion's x, y, z, w.
using PoseBlock = std::array<double, 7>;
PoseBlock to_block(const SE3& T);
SE3 from_block(const double* block);

// One row a residual: a cost's derivatives by a pose block.
template <int Rows>
using PoseBlockJacobian = Eigen::Matrix<double, Rows, 7, Eigen::RowMajor>;

// Plus is retract(): T * (t, Exp(r)). Its Jacobian is declared as [I6; 0], and every cost on it
// returns derivatives by that increment in the first six columns, 0 in the seventh: the
// quaternion's own derivative is never formed (as in OKVIS, Leutenegger et al. 2015). Stateless.
class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

// Writes derivatives by the increment where Ceres wants those by the block: [J, 0].
template <int Rows>
void to_block_jacobian(const Eigen::Matrix<double, Rows, 6>& by_increment, double* jacobian) {
  Eigen::Map<PoseBlockJacobian<Rows>> J(jacobian);
  J.template leftCols<6>() = by_increment;
  J.col(6).setZero();
}

}  // namespace fusion_slam
