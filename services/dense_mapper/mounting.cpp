#include "services/dense_mapper/mounting.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

namespace fusion_slam {
namespace {

constexpr double kCosLevel = 0.97;     // 14 degrees: normals of far floor are rough
constexpr double kMostSlope = 0.07;    // 4 degrees
constexpr double kMostHeightM = 0.06;  // at the robot
constexpr std::size_t kFewestSurfaces = 40;
constexpr double kFewestSpreadM = 0.25;  // standard deviation along x: else the slope is a guess
constexpr double kPriorSlope = 0.02;     // how well people mount cameras, against
constexpr double kPriorHeightM = 0.01;
constexpr double kSigmaM = 0.05;  // one surface, with what all of them share
constexpr std::array<double, 3> kGatesM = {0.10, 0.05, 0.03};
constexpr std::size_t kLatest = 101;
// A mounting is left as it is on paper until it is off by half a voxel at 5 m; from then on the
// correction follows smaller changes.
constexpr double kOffSlope = 0.0045;  // 0.26 degrees
constexpr double kOffHeightM = 0.015;
constexpr double kWorthSlope = 0.0017;  // 0.1 degree: 1 cm at 6 m
constexpr double kWorthHeightM = 0.005;

double height(const FloorPlane& plane, const Eigen::Vector3d& p) {
  return plane.slope_x * p.x() + plane.slope_y * p.y() + plane.height_m;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::optional<FloorPlane> fit_floor(const std::vector<SurfacePoint>& surfaces_camera,
                                    const SE3& T_base_camera) {
  std::vector<Eigen::Vector3d> level;
  for (const SurfacePoint& surface : surfaces_camera) {
    const Eigen::Vector3d p = T_base_camera * surface.p_m.cast<double>();
    const Eigen::Vector3d normal = T_base_camera.linear() * surface.normal.cast<double>();
    if (normal.z() < kCosLevel) continue;
    if (std::abs(p.z()) < kMostHeightM + kMostSlope * p.head<2>().norm()) level.push_back(p);
  }
  FloorPlane plane;
  for (std::size_t round = 0; round < kGatesM.size(); ++round) {
    const double weight = 1.0 / (kSigmaM * kSigmaM);
    Eigen::Matrix3d A =
        Eigen::Vector3d(1.0 / (kPriorSlope * kPriorSlope), 1.0 / (kPriorSlope * kPriorSlope),
                        1.0 / (kPriorHeightM * kPriorHeightM))
            .asDiagonal();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    std::size_t n = 0;
    double sum = 0.0;
    double squared = 0.0;
    for (const Eigen::Vector3d& p : level) {
      if (round > 0 && std::abs(p.z() - height(plane, p)) > kGatesM[round]) continue;
      const Eigen::Vector3d row(p.x(), p.y(), 1.0);
      A += weight * row * row.transpose();
      b += weight * row * p.z();
      sum += p.x();
      squared += p.x() * p.x();
      ++n;
    }
    if (n < kFewestSurfaces) return std::nullopt;
    const double mean = sum / static_cast<double>(n);
    if (squared / static_cast<double>(n) - mean * mean < kFewestSpreadM * kFewestSpreadM)
      return std::nullopt;
    const Eigen::Vector3d solution = A.ldlt().solve(b);
    plane = {solution.x(), solution.y(), solution.z()};
  }
  if (std::hypot(plane.slope_x, plane.slope_y) > kMostSlope ||
      std::abs(plane.height_m) > kMostHeightM)
    return std::nullopt;
  return plane;
}

Mounting::Mounting(const MountingState& state) : state_(state) {
  if (state_.off) T_true_base_ = levelled_floor(state_.used);
}

void Mounting::add(const DepthCloud& cloud, const SE3& T_base_camera) {
  const auto floor = fit_floor(cloud.surfaces, T_base_camera);
  if (!floor) return;
  ++state_.n_floors;
  state_.floors.push_back(*floor);
  if (state_.floors.size() > kLatest) state_.floors.pop_front();
  std::vector<double> x, y, z;
  for (const FloorPlane& one : state_.floors) {
    x.push_back(one.slope_x);
    y.push_back(one.slope_y);
    z.push_back(one.height_m);
  }
  const FloorPlane now{median(x), median(y), median(z)};
  if (std::hypot(now.slope_x - state_.used.slope_x, now.slope_y - state_.used.slope_y) <
          (state_.off ? kWorthSlope : kOffSlope) &&
      std::abs(now.height_m - state_.used.height_m) < (state_.off ? kWorthHeightM : kOffHeightM))
    return;
  state_.off = true;
  state_.used = now;
  T_true_base_ = levelled_floor(now);
}

SE3 levelled_floor(const FloorPlane& floor) {
  SE3 T = SE3::Identity();
  T.linear() = rotation_to_z(Eigen::Vector3d(-floor.slope_x, -floor.slope_y, 1.0).normalized());
  T.translation().z() = -(T.linear() * Eigen::Vector3d(0, 0, floor.height_m)).z();
  return T;
}

}  // namespace fusion_slam
