#include "libs/scan_matching/occupancy_cost.hpp"

#include <cmath>

namespace fusion_slam {
namespace {

// Weights of the four neighbours of a Catmull-Rom spline at t in [0, 1), and their derivatives.
struct Spline {
  double w[4];
  double d[4];
};

Spline spline_at(double t) {
  const double t2 = t * t, t3 = t2 * t;
  return {{0.5 * (-t3 + 2.0 * t2 - t), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
           0.5 * (-3.0 * t3 + 4.0 * t2 + t), 0.5 * (t3 - t2)},
          {0.5 * (-3.0 * t2 + 4.0 * t - 1.0), 0.5 * (9.0 * t2 - 10.0 * t),
           0.5 * (-9.0 * t2 + 8.0 * t + 1.0), 0.5 * (3.0 * t2 - 2.0 * t)}};
}

}  // namespace

Interpolated interpolate_probability(const Raster& raster, double x_m, double y_m) {
  const double u = x_m / raster.resolution_m() - 0.5;  // values sit at the cells' centres
  const double v = y_m / raster.resolution_m() - 0.5;
  const double u0 = std::floor(u), v0 = std::floor(v);
  const Spline sx = spline_at(u - u0), sy = spline_at(v - v0);
  const int x = static_cast<int>(u0) - 1, y = static_cast<int>(v0) - 1;
  const auto& table = match_probability();
  const bool inside = raster.contains(x, y) && raster.contains(x + 3, y + 3);
  Interpolated out;
  for (int j = 0; j < 4; ++j) {
    double value = 0.0, slope = 0.0;
    const std::uint8_t* cells = inside ? raster.row(y + j) + (x - raster.min_x()) : nullptr;
    for (int i = 0; i < 4; ++i) {
      const double p = table[inside ? cells[i] : raster.at(x + i, y + j)];
      value += sx.w[i] * p;
      slope += sx.d[i] * p;
    }
    out.value += sy.w[j] * value;
    out.d_dx += sy.w[j] * slope;
    out.d_dy += sy.d[j] * value;
  }
  out.d_dx /= raster.resolution_m();
  out.d_dy /= raster.resolution_m();
  return out;
}

OccupancyCost::OccupancyCost(const Raster& raster, const Points& points_base, double sigma)
    : raster_(raster), points_(points_base), sigma_(sigma) {
  set_num_residuals(static_cast<int>(points_base.size()));
  mutable_parameter_block_sizes()->push_back(3);
}

bool OccupancyCost::Evaluate(double const* const* parameters, double* residuals,
                             double** jacobians) const {
  const double* pose = parameters[0];
  const double c = std::cos(pose[2]), s = std::sin(pose[2]);
  double* jacobian = jacobians != nullptr ? jacobians[0] : nullptr;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const double rx = c * points_[i].x() - s * points_[i].y();
    const double ry = s * points_[i].x() + c * points_[i].y();
    const Interpolated m = interpolate_probability(raster_, pose[0] + rx, pose[1] + ry);
    residuals[i] = (1.0 - m.value) / sigma_;
    if (jacobian == nullptr) continue;
    jacobian[3 * i] = -m.d_dx / sigma_;
    jacobian[3 * i + 1] = -m.d_dy / sigma_;
    jacobian[3 * i + 2] = -(m.d_dx * -ry + m.d_dy * rx) / sigma_;
  }
  return true;
}

PriorCost::PriorCost(const SE2& predicted, double sigma_linear_m, double sigma_angular_rad)
    : predicted_(predicted),
      sigma_linear_m_(sigma_linear_m),
      sigma_angular_rad_(sigma_angular_rad) {}

bool PriorCost::Evaluate(double const* const* parameters, double* residuals,
                         double** jacobians) const {
  const double* pose = parameters[0];
  residuals[0] = (pose[0] - predicted_.x) / sigma_linear_m_;
  residuals[1] = (pose[1] - predicted_.y) / sigma_linear_m_;
  residuals[2] = wrap_angle(pose[2] - predicted_.yaw) / sigma_angular_rad_;
  if (jacobians == nullptr || jacobians[0] == nullptr) return true;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> J(jacobians[0]);
  J.setZero();
  J(0, 0) = J(1, 1) = 1.0 / sigma_linear_m_;
  J(2, 2) = 1.0 / sigma_angular_rad_;
  return true;
}

}  // namespace fusion_slam
