#include "services/dense_mapper/level.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace fusion_slam {
namespace {

constexpr std::size_t kFewestSurfaces = 100;
constexpr std::size_t kCandidates = 300;
constexpr std::size_t kMostSurfaces =
    20000;  // evenly picked: the time stays the same however long the recording
constexpr double kCosPrior = 0.64;    // up is within 50 degrees of the images' up
constexpr double kSinAligned = 0.10;  // 6 degrees: level or upright
constexpr double kUprightWeight =
    0.25;  // upright surfaces say less: any direction in their plane could be up
constexpr double kBinM = 0.025;
constexpr double kFloorShare = 0.04;  // of the level surfaces: fewer is an object, not the floor
constexpr double kFloorBelowCameraM = 0.7;  // a person holds a camera higher than this
constexpr double kWorthRad = 0.005;         // 5 cm at 10 m
constexpr double kWorthCells = 0.5;
constexpr double kSigmaTiltRad = 0.01;    // the surfaces' normals and the map's own bend
constexpr double kSigmaFloorM = 0.02;     // a bin
constexpr double kSigmaNoFloorM = 0.3;    // what lies lowest need not lie on the floor
constexpr double kUnknownVariance = 1e6;  // 1 km, any turn

bool level_surface(const Eigen::Vector3d& n, const Eigen::Vector3d& up) {
  return n.cross(up).norm() < kSinAligned;
}
bool upright_surface(const Eigen::Vector3d& n, const Eigen::Vector3d& up) {
  return std::abs(n.dot(up)) < kSinAligned;
}

double score(const std::vector<Eigen::Vector3d>& normals, const Eigen::Vector3d& up) {
  double sum = 0.0;
  for (const Eigen::Vector3d& n : normals) {
    if (level_surface(n, up)) sum += 1.0;
    if (upright_surface(n, up)) sum += kUprightWeight;
  }
  return sum;
}

// The direction most level surfaces have, tried on the surfaces themselves; the best hypothesis
// counts.
Eigen::Vector3d best_candidate(const std::vector<Eigen::Vector3d>& normals,
                               const Eigen::Vector3d& image_up) {
  std::vector<Eigen::Vector3d> candidates;
  for (const Eigen::Vector3d& n : normals)
    if (n.dot(image_up) > kCosPrior) candidates.push_back(n);
  Eigen::Vector3d best = image_up;
  double best_score = score(normals, image_up);
  const std::size_t every = std::max<std::size_t>(1, candidates.size() / kCandidates);
  for (std::size_t i = 0; i < candidates.size(); i += every) {
    const double s = score(normals, candidates[i]);
    if (s > best_score) {
      best_score = s;
      best = candidates[i];
    }
  }
  return best;
}

// Least squares: level normals along up, upright ones across it.
Eigen::Vector3d refine(const std::vector<Eigen::Vector3d>& normals, Eigen::Vector3d up) {
  for (int iteration = 0; iteration < 8; ++iteration) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& n : normals) {
      if (level_surface(n, up)) A += Eigen::Matrix3d::Identity() - n * n.transpose();
      if (upright_surface(n, up)) A += kUprightWeight * n * n.transpose();
    }
    if (A.isZero()) return up;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(A);
    const Eigen::Vector3d better = solver.eigenvectors().col(0);
    up = better.dot(up) < 0.0 ? Eigen::Vector3d(-better) : better;
  }
  return up;
}

// Height of the lowest large level surface that lies well below the cameras.
std::optional<double> floor_height(const std::vector<SurfacePoint>& surfaces,
                                   const Eigen::Vector3d& up, double camera_height_m) {
  std::vector<double> heights;
  for (const SurfacePoint& s : surfaces)
    if (s.normal.cast<double>().dot(up) > 0.97) heights.push_back(s.p_m.cast<double>().dot(up));
  if (heights.empty()) return std::nullopt;
  const double low = *std::min_element(heights.begin(), heights.end());
  const double high = *std::max_element(heights.begin(), heights.end());
  std::vector<double> bins(static_cast<std::size_t>((high - low) / kBinM) + 3, 0.0);
  for (const double h : heights) bins[static_cast<std::size_t>((h - low) / kBinM) + 1] += 1.0;
  const double enough = std::max(20.0, kFloorShare * static_cast<double>(heights.size()));
  for (std::size_t i = 1; i + 1 < bins.size(); ++i) {
    const double height = low + (static_cast<double>(i) - 0.5) * kBinM;
    if (height > camera_height_m - kFloorBelowCameraM) break;
    const double here = bins[i - 1] + bins[i] + bins[i + 1];
    if (here < enough || bins[i] < bins[i - 1] || bins[i] < bins[i + 1]) continue;
    double sum = 0.0;
    double count = 0.0;
    for (const double h : heights) {
      if (std::abs(h - height) > 2.0 * kBinM) continue;
      sum += h;
      count += 1.0;
    }
    return sum / count;
  }
  return std::nullopt;
}

// Without a floor: nearly everything seen is above this.
double low_height(const std::vector<SurfacePoint>& surfaces, const Eigen::Vector3d& up) {
  std::vector<double> heights;
  heights.reserve(surfaces.size());
  for (const SurfacePoint& s : surfaces) heights.push_back(s.p_m.cast<double>().dot(up));
  const auto at = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 50);
  std::nth_element(heights.begin(), at, heights.end());
  return *at;
}

}  // namespace

std::optional<Level> estimate_level(const std::vector<SurfacePoint>& all_surfaces,
                                    const Eigen::Vector3d& image_up,
                                    const std::vector<Eigen::Vector3d>& camera_positions_m) {
  if (all_surfaces.size() < kFewestSurfaces || camera_positions_m.empty() || image_up.isZero())
    return std::nullopt;
  std::vector<SurfacePoint> surfaces;
  const std::size_t n = std::min(all_surfaces.size(), kMostSurfaces);
  for (std::size_t i = 0; i < n; ++i) surfaces.push_back(all_surfaces[i * all_surfaces.size() / n]);
  std::vector<Eigen::Vector3d> normals;
  normals.reserve(surfaces.size());
  for (const SurfacePoint& s : surfaces) normals.push_back(s.normal.cast<double>());
  const Eigen::Vector3d up = refine(normals, best_candidate(normals, image_up.normalized()));

  double camera_height_m = 0.0;
  for (const Eigen::Vector3d& p : camera_positions_m) camera_height_m += p.dot(up);
  camera_height_m /= static_cast<double>(camera_positions_m.size());
  Level level;
  level.T_level_map.linear() = rotation_to_z(up);
  if (const auto height_m = floor_height(surfaces, up, camera_height_m)) {
    level.T_level_map.translation().z() = -*height_m;
    level.floor_seen = true;
  } else {
    level.T_level_map.translation().z() = -low_height(surfaces, up);
  }
  return level;
}

bool worth_levelling(const SE3& T_level_map, double resolution_m) {
  return log_so3(T_level_map.linear()).norm() > kWorthRad ||
         std::abs(T_level_map.translation().z()) > kWorthCells * resolution_m;
}

Matrix6d level_covariance(const SE3& T_level_anchor, bool floor_seen) {
  const double sigma_z_m = floor_seen ? kSigmaFloorM : kSigmaNoFloorM;
  Matrix6d level = Matrix6d::Zero();  // in the level frame's axes
  level.diagonal() << kUnknownVariance, kUnknownVariance, sigma_z_m * sigma_z_m,
      kSigmaTiltRad * kSigmaTiltRad, kSigmaTiltRad * kSigmaTiltRad, kUnknownVariance;
  Matrix6d to_anchor = Matrix6d::Zero();
  to_anchor.topLeftCorner<3, 3>() = T_level_anchor.linear().transpose();
  to_anchor.bottomRightCorner<3, 3>() = T_level_anchor.linear().transpose();
  return to_anchor * level * to_anchor.transpose();
}

}  // namespace fusion_slam
