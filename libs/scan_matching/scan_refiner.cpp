#include "libs/scan_matching/scan_refiner.hpp"

#include <cmath>

#include "libs/scan_matching/occupancy_cost.hpp"
#include "libs/scan_matching/surface_refiner.hpp"

namespace fusion_slam {
namespace {

constexpr double kNormalBaseline_m = 0.15;  // shorter, and the ranges' noise turns the normal
constexpr std::size_t kNormalReach = 12;    // points

// Surface normals of the points in base, zero where a point belongs to no straight piece. Points in
// the order of beams.
Points surface_normals(const Points& points) {
  Points normals(points.size(), Eigen::Vector2d::Zero());
  const auto neighbour = [&](std::size_t i, int step) -> const Eigen::Vector2d* {
    std::size_t k = i;
    for (std::size_t n = 0; n < kNormalReach; ++n) {
      k += static_cast<std::size_t>(step);  // below 0 wraps to a number past the end
      if (k >= points.size()) return nullptr;
      if ((points[k] - points[i]).norm() >= kNormalBaseline_m) return &points[k];
    }
    return nullptr;
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d *before = neighbour(i, -1), *after = neighbour(i, 1);
    if (before == nullptr || after == nullptr) continue;
    const Eigen::Vector2d in = (points[i] - *before).normalized();
    const Eigen::Vector2d out = (*after - points[i]).normalized();
    if (in.dot(out) < 0.94) continue;  // 20 degrees
    const Eigen::Vector2d along = (*after - *before).normalized();
    normals[i] = {-along.y(), along.x()};
  }
  return normals;
}

// What the scan knows of the pose: J^T J of the points' residuals, where a point of a straight
// surface counts across it only. (The map's texture along a wall is noise that looks like
// knowledge.) Averaged over poses half a cell around: at the very top of a ridge the slope is 0
// although the wall fixes the pose well.
Eigen::Matrix3d point_information(const Raster& raster, const Points& points, const double* pose,
                                  double sigma) {
  const Eigen::Rotation2Dd R(pose[2]);
  const Points normals = surface_normals(points);
  const double half_cell = 0.5 * raster.resolution_m();
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d arm = R * points[i], n = R * normals[i];
    for (const double dx : {-half_cell, half_cell})
      for (const double dy : {-half_cell, half_cell}) {
        const Interpolated m =
            interpolate_probability(raster, pose[0] + arm.x() + dx, pose[1] + arm.y() + dy);
        Eigen::Vector2d slope(m.d_dx, m.d_dy);
        if (!n.isZero()) slope = n * n.dot(slope);
        const Eigen::Vector3d J(slope.x(), slope.y(), slope.y() * arm.x() - slope.x() * arm.y());
        sum += J * J.transpose();
      }
  }
  return sum / (4.0 * sigma * sigma);
}

}  // namespace

RefinedMatch refine_match(const Raster& raster, const Points& points_base, const SE2& start,
                          const PosePrior& prior, const RefinerOptions& options) {
  double pose[3] = {start.x, start.y, start.yaw};
  OccupancyCost points_cost(raster, points_base, options.residual_sigma);
  PriorCost prior_cost(prior.T_grid_base, prior.sigma_linear_m, prior.sigma_angular_rad);

  ceres::Problem::Options problem_options;
  problem_options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  if (!points_base.empty()) problem.AddResidualBlock(&points_cost, nullptr, pose);
  problem.AddResidualBlock(&prior_cost, nullptr, pose);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.max_solver_time_in_seconds = 1e9;  // iterations bound it, never the clock
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);

  RefinedMatch match;
  const Eigen::Matrix3d information =
      point_information(raster, points_base, pose, options.residual_sigma);
  Eigen::Matrix3d prior_information = Eigen::Matrix3d::Zero();
  prior_information.diagonal() << std::pow(prior.sigma_linear_m, -2),
      std::pow(prior.sigma_linear_m, -2), std::pow(prior.sigma_angular_rad, -2);
  const Eigen::Matrix3d covariance = (information + prior_information).inverse();
  // Along directions that the scan doesn't know the prediction stands, whatever the solver found
  // there.
  const SE2& predicted = prior.T_grid_base;
  const Eigen::Vector3d found(pose[0] - predicted.x, pose[1] - predicted.y,
                              wrap_angle(pose[2] - predicted.yaw));
  const Eigen::Vector3d kept = covariance * information * found;
  match.T_grid_base = {predicted.x + kept.x(), predicted.y + kept.y(),
                       wrap_angle(predicted.yaw + kept.z())};
  match.weakest_sigma_m = weakest_sigma_m(information);
  Eigen::Matrix3d to_base = Eigen::Matrix3d::Identity();  // grid axes to base axes
  to_base.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-pose[2]).toRotationMatrix();
  match.covariance = to_base * covariance * to_base.transpose();
  return match;
}

}  // namespace fusion_slam
