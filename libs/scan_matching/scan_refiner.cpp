#include "libs/scan_matching/scan_refiner.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "libs/scan_matching/occupancy_cost.hpp"

namespace fusion_slam {
namespace {

// J^T J of the points' residuals alone, averaged over poses half a cell around: at the very top of
// a ridge the slope is 0 although the wall fixes the pose well.
Eigen::Matrix3d point_information(const OccupancyCost& cost, const double* pose,
                                  double half_cell_m) {
  const int n = cost.num_residuals();
  Eigen::VectorXd residuals(n);
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> jacobian(n, 3);
  double* blocks[] = {jacobian.data()};
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const double dx : {-half_cell_m, half_cell_m})
    for (const double dy : {-half_cell_m, half_cell_m}) {
      const double moved[3] = {pose[0] + dx, pose[1] + dy, pose[2]};
      const double* parameters[] = {moved};
      cost.Evaluate(parameters, residuals.data(), blocks);
      sum += jacobian.transpose() * jacobian;
    }
  return sum / 4.0;
}

double weakest_sigma(const Eigen::Matrix3d& information) {
  // Translation once the heading is free to follow: Schur complement.
  const Eigen::Vector2d cross = information.block<2, 1>(0, 2);
  const double turn = std::max(information(2, 2), 1e-9);
  const Eigen::Matrix2d translation =
      information.topLeftCorner<2, 2>() - cross * cross.transpose() / turn;
  const double least =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(translation).eigenvalues().x();
  return least > 1e-9 ? 1.0 / std::sqrt(least) : std::numeric_limits<double>::infinity();
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
  match.T_grid_base = {pose[0], pose[1], wrap_angle(pose[2])};
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  if (!points_base.empty())
    information = point_information(points_cost, pose, 0.5 * raster.resolution_m());
  match.weakest_sigma_m = weakest_sigma(information);
  information(0, 0) += 1.0 / (prior.sigma_linear_m * prior.sigma_linear_m);
  information(1, 1) += 1.0 / (prior.sigma_linear_m * prior.sigma_linear_m);
  information(2, 2) += 1.0 / (prior.sigma_angular_rad * prior.sigma_angular_rad);
  Eigen::Matrix3d to_base = Eigen::Matrix3d::Identity();  // grid axes to base axes
  to_base.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-pose[2]).toRotationMatrix();
  match.covariance = to_base * information.inverse() * to_base.transpose();
  return match;
}

}  // namespace fusion_slam
