#include "libs/scan_matching/surface_refiner.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "libs/scan_matching/occupancy_cost.hpp"

namespace fusion_slam {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kRobustSigmas = 2.5;  // Cauchy's scale: beyond it a point loses its say

// Normal equations of all points at one pose and velocity.
struct Equations {
  Matrix6 H = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
  double cost = 0.0;
  int n_on_surfaces = 0;

  void operator+=(const Equations& other) {
    H += other.H, g += other.g, cost += other.cost, n_on_surfaces += other.n_on_surfaces;
  }

  void add(const Eigen::Vector3d& J, double residual, double weight, double time_s) {
    const Eigen::Matrix3d JJ = weight * J * J.transpose();
    const Eigen::Vector3d Jr = weight * residual * J;
    H.topLeftCorner<3, 3>() += JJ;
    H.topRightCorner<3, 3>() += time_s * JJ;
    H.bottomRightCorner<3, 3>() += time_s * time_s * JJ;
    g.head<3>() += Jr;
    g.tail<3>() += time_s * Jr;
  }
};

// Normals err by a degree or so; walls that are all parallel then seem to say a little about the
// position along them, the same wrong thing scan after scan, which pulls a robot back in a
// corridor. So much of the strongest direction's knowledge is noise in the weakest one's, and is
// taken out of it (after Zhang et al. 2016, "On degeneracy of optimization-based state estimation
// problems").
constexpr double kNormalNoise_rad = 0.02;

void discount_noise(Equations& e) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(e.H.topLeftCorner<2, 2>());
  const double weak = eigen.eigenvalues().x(), strong = eigen.eigenvalues().y();
  if (!(weak > 0.0)) return;
  const double part = 1.0 - kNormalNoise_rad * kNormalNoise_rad * strong / weak;
  const Eigen::Vector2d v = eigen.eigenvectors().col(0);
  Matrix6 S = Matrix6::Identity();
  const Eigen::Matrix2d less =
      Eigen::Matrix2d::Identity() - (1.0 - std::sqrt(std::max(part, 0.0))) * v * v.transpose();
  S.block<2, 2>(0, 0) = less;
  S.block<2, 2>(3, 3) = less;
  e.H = (S * e.H * S).eval();
  e.g = (S * e.g).eval();
}

// Is there still something at, or one cell beside, the point? A wall on the border of two cells
// fills now one, now the other.
bool stands(const Raster& raster, const Eigen::Vector2d& point) {
  static const std::uint8_t even = cell_from_probability(0.5);
  const CellIndex c = raster.cell_of(point.x(), point.y());
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (raster.at(c.x + dx, c.y + dy) > even) return true;
  return false;
}

Equations linearise(const SurfaceMap& surfaces, const Raster& raster, const SweepPoints& sweep,
                    const SE2& T, const Twist& twist, const SurfaceRefinerOptions& options) {
  const double line_weight = 1.0 / (options.sigma_m * options.sigma_m * options.redundancy);
  const double cell_weight =
      1.0 / (options.occupancy_sigma * options.occupancy_sigma * options.redundancy);
  const double scale = kRobustSigmas * options.sigma_m;
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(T.yaw).toRotationMatrix();
  Equations lines, cells;
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    const double time_s = sweep.time_s.empty() ? 0.0 : sweep.time_s[i];
    Eigen::Vector2d p = sweep.points[i], n = sweep.normals[i];
    if (time_s > 0.0) {
      const SE2 m = twist.motion(time_s);
      p = m * p;
      n = Eigen::Rotation2Dd(m.yaw) * n;
    }
    const Eigen::Vector2d q = T * p;
    const auto jacobian =
        [&](const Eigen::Vector2d& slope) {  // d(slope . q) / d(x, y, yaw) in base
          const Eigen::Vector2d s = R.transpose() * slope;
          return Eigen::Vector3d(s.x(), s.y(), s.y() * p.x() - s.x() * p.y());
        };
    const Surface* surface = n.isZero() ? nullptr : surfaces.find(q, R * n);
    if (surface != nullptr && !stands(raster, surface->point)) surface = nullptr;
    if (surface != nullptr) {
      const double r = surface->normal.dot(q - surface->point);
      // The surface errs too: as one point does by the number of its points.
      const double known = line_weight / (1.0 + 1.0 / surface->weight);
      const double w = known / (1.0 + r * r / (scale * scale));
      lines.add(jacobian(surface->normal), r, w, time_s);
      lines.cost += 0.5 * known * scale * scale * std::log1p(r * r / (scale * scale));
      ++lines.n_on_surfaces;
    } else {
      const Interpolated m = interpolate_probability(raster, q.x(), q.y());
      Eigen::Vector2d slope(-m.d_dx, -m.d_dy);
      // A wall that the surfaces don't know yet: across it only. The map's texture along a wall is
      // noise that looks like knowledge.
      if (!n.isZero()) slope = (R * n) * (R * n).dot(slope);
      cells.add(jacobian(slope), 1.0 - m.value, cell_weight, time_s);
      cells.cost += 0.5 * cell_weight * (1.0 - m.value) * (1.0 - m.value);
    }
  }
  for (Equations* e : {&lines, &cells}) e->H.bottomLeftCorner<3, 3>() = e->H.topRightCorner<3, 3>();
  discount_noise(lines);
  lines += cells;
  return lines;
}

// Marginal of the pose: the velocity is free to follow as far as its prior allows.
Eigen::Matrix3d pose_information(const Matrix6& H) {
  const Eigen::Matrix3d cross = H.topRightCorner<3, 3>();
  const Eigen::Matrix3d follow = H.bottomRightCorner<3, 3>();
  return H.topLeftCorner<3, 3>() - cross * follow.ldlt().solve(cross.transpose());
}

}  // namespace

SurfaceCost surface_cost(const SurfaceMap& surfaces, const Raster& raster, const SweepPoints& sweep,
                         const SE2& T_grid_base, const Twist& twist,
                         const SurfaceRefinerOptions& options) {
  const Equations e = linearise(surfaces, raster, sweep, T_grid_base, twist, options);
  return {e.cost, e.g};
}

double weakest_sigma_m(const Eigen::Matrix3d& information) {
  const Eigen::Vector2d cross = information.block<2, 1>(0, 2);
  const double turn = std::max(information(2, 2), 1e-9);
  const Eigen::Matrix2d translation =
      information.topLeftCorner<2, 2>() - cross * cross.transpose() / turn;
  const double least =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(translation).eigenvalues().x();
  return least > 1e-9 ? 1.0 / std::sqrt(least) : std::numeric_limits<double>::infinity();
}

SurfaceMatch refine_on_surfaces(const SurfaceMap& surfaces, const Raster& raster,
                                const SweepPoints& sweep, const SE2& start,
                                const MotionPrior& prior, const SurfaceRefinerOptions& options) {
  Matrix6 P = Matrix6::Zero();  // information of the prior
  P.topLeftCorner<3, 3>() = prior.covariance.inverse();
  P.bottomRightCorner<3, 3>() = prior.twist_sigma.array().square().inverse().matrix().asDiagonal();
  SE2 T = start;
  Twist twist = prior.twist;
  Equations e;
  for (int i = 0; i < options.max_iterations; ++i) {
    e = linearise(surfaces, raster, sweep, T, twist, options);
    const SE2 off = prior.T_grid_base.inverse() * T;
    Vector6 from_prior;
    from_prior << off.x, off.y, off.yaw, twist.vx_mps - prior.twist.vx_mps,
        twist.vy_mps - prior.twist.vy_mps, twist.turn_radps - prior.twist.turn_radps;
    const Vector6 step = -(e.H + P).ldlt().solve(e.g + P * from_prior);
    T = T * SE2{step[0], step[1], step[2]};
    twist.vx_mps += step[3], twist.vy_mps += step[4], twist.turn_radps += step[5];
    if (step.head<2>().norm() < 1e-4 && std::abs(step[2]) < 1e-5) break;
  }
  SurfaceMatch match;
  match.T_grid_base = {T.x, T.y, wrap_angle(T.yaw)};
  match.twist = twist;
  Matrix6 data = e.H;
  data.bottomRightCorner<3, 3>() += P.bottomRightCorner<3, 3>();
  match.information = pose_information(data);
  match.covariance = (match.information + P.topLeftCorner<3, 3>()).inverse();
  match.weakest_sigma_m = weakest_sigma_m(match.information);
  match.n_on_surfaces = e.n_on_surfaces;
  return match;
}

}  // namespace fusion_slam
