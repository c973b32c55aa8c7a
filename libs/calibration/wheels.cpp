#include "libs/calibration/wheels.hpp"

#include <cmath>

#include "libs/calibration/blocks.hpp"
#include "libs/calibration/floor.hpp"

namespace fusion_slam {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;  // x, y, yaw, way scale - 1, turn scale - 1, delay

// Long enough for scan matching's noise to be small against the motion, short enough for the
// wheels' errors to stay small.
constexpr double kWindow_us = 1e6;
constexpr double kSigma_m = 0.005;
constexpr double kSigma_rad = 0.004;
constexpr int kRounds = 12;
constexpr double kLeastTurn_rad = 3.0;
constexpr std::size_t kFewest = 30;

struct Window {
  double begin_us;
  double end_us;
  std::int64_t block;
  SE2 T_begin_end;  // the LiDAR's motion
};

bool known(const PlanarPath& path, const Window& w, double delay_s) {
  return path.knows(w.begin_us - 1e6 * delay_s) && path.knows(w.end_us - 1e6 * delay_s);
}

// A X - X B: two of translation, one of rotation, in sigmas.
Eigen::Vector3d residual(const Window& w, const PlanarPath& odometry, const Vector6& p) {
  const SE2 A = odometry.at(w.begin_us - 1e6 * p(5)).inverse() * odometry.at(w.end_us - 1e6 * p(5));
  const SE2& B = w.T_begin_end;
  const Eigen::Vector2d x(p(0), p(1));
  // The scans know the turn better than the wheels do: what the wheels' heading gathered in error
  // (unequal wheels) bent their way by half of it.
  const Eigen::Rotation2Dd unbend(0.5 * wrap_angle(B.yaw - A.yaw));
  const Eigen::Vector2d way = (1.0 + p(3)) * (unbend * Eigen::Vector2d(A.x, A.y));
  const Eigen::Vector2d left = way + Eigen::Rotation2Dd(B.yaw) * x;
  const Eigen::Vector2d right = Eigen::Rotation2Dd(p(2)) * Eigen::Vector2d(B.x, B.y) + x;
  const Eigen::Vector2d e = (left - right) / kSigma_m;
  return {e.x(), e.y(), wrap_angle((1.0 + p(4)) * A.yaw - B.yaw) / kSigma_rad};
}

}  // namespace

std::optional<LidarOnWheels> find_lidar_on_wheels(const PlanarPath& lidar,
                                                  const PlanarPath& odometry, const SE2& start) {
  if (odometry.size() < 2 || lidar.size() < 2) return std::nullopt;
  std::vector<Window> windows;
  double turned_rad = 0.0;
  for (std::size_t i = 0; i + 1 < lidar.size(); ++i) {
    const auto begin_us = static_cast<double>(lidar.times_us()[i]);
    const double end_us = begin_us + kWindow_us;
    if (!lidar.knows(begin_us) || !lidar.knows(end_us)) continue;
    const Window w{begin_us, end_us, block_of(lidar.times_us()[i]),
                   lidar.at(begin_us).inverse() * lidar.at(end_us)};
    windows.push_back(w);
    turned_rad += std::abs(w.T_begin_end.yaw) * 1e-6 *
                  static_cast<double>(lidar.times_us()[i + 1] - lidar.times_us()[i]) /
                  (1e-6 * kWindow_us);
  }
  if (windows.size() < kFewest || turned_rad < kLeastTurn_rad) return std::nullopt;
  Vector6 p = Vector6::Zero();
  p.head<3>() << start.x, start.y, start.yaw;
  const Vector6 steps = (Vector6() << 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-3).finished();
  Eigen::Matrix<double, 6, 6> covariance;
  for (int round = 0; round < kRounds; ++round) {
    BlockEquations<6> equations;
    for (const Window& w : windows) {
      if (!known(odometry, w, p(5) - 0.01) || !known(odometry, w, p(5) + 0.01)) continue;
      const Eigen::Vector3d r = residual(w, odometry, p);
      Eigen::Matrix<double, 3, 6> J;
      for (int k = 0; k < 6; ++k)
        J.col(k) = (residual(w, odometry, p + steps(k) * Vector6::Unit(k)) -
                    residual(w, odometry, p - steps(k) * Vector6::Unit(k))) /
                   (2 * steps(k));
      const double weight = 1.0 / (1.0 + r.squaredNorm() / 9.0);  // Cauchy: wheels slip
      for (int k = 0; k < 3; ++k) equations.add(w.block, J.row(k), r(k), weight);
    }
    if (equations.residuals() < 3 * kFewest) return std::nullopt;
    // Scales within a few per cent, clocks within a tenth of a second.
    const Vector6 precision = (Vector6() << 0, 0, 0, 400.0, 400.0, 100.0).finished();
    equations.add_prior(precision, p);
    p += equations.step();
    covariance = equations.covariance();
  }
  LidarOnWheels found;
  found.T_base_lidar = {p(0), p(1), wrap_angle(p(2))};
  found.covariance = covariance.topLeftCorner<3, 3>();
  found.way_scale = 1.0 + p(3);
  found.turn_scale = 1.0 + p(4);
  found.delay_s = p(5);
  found.turned_rad = turned_rad;
  return found;
}

}  // namespace fusion_slam
