#include "libs/calibration/floor.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "libs/calibration/blocks.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kBlock_us = 5'000'000;
const double kMostTurn_cos = std::cos(15.0 * M_PI / 180.0);
constexpr double kMostHeight_m = 0.20;
constexpr int kTriples = 80;
constexpr std::size_t kFewest = 60;  // sampled pixels on the floor of a frame
constexpr double kGate_sigmas = 2.5;
constexpr double kMostDepth_m = 4.5;  // beyond, steps of depth are larger than what we look for
constexpr int kRounds = 4;
constexpr int kFewestFrames = 20;

struct Sample {
  Eigen::Vector3d ray;
  double inverse_m;
  double sigma;  // of inverse_m
};

// A plane in front of the camera: inverse depth = a . ray; up = -a / |a|, height = 1 / |a|.
bool plausible(const Eigen::Vector3d& a, const Eigen::Vector3d& up_camera, double height_m) {
  const double norm = a.norm();
  if (!(norm > 0.1) || !std::isfinite(norm)) return false;
  return -a.dot(up_camera) / norm > kMostTurn_cos &&
         std::abs(1.0 / norm - height_m) < kMostHeight_m;
}

std::vector<Sample> candidates(const DepthFrame& frame, const CameraModel& camera,
                               const SE3& T_base_camera) {
  std::vector<Sample> samples;
  for (std::size_t c = 0; c < frame.columns.size(); c += 2)
    for (const DepthRay& ray : frame.columns[c]) {
      const Eigen::Vector3d p = ray.point_m();
      const double z_m = p.z();
      const double height_m = (T_base_camera * p).z();
      if (z_m > kMostDepth_m || std::abs(height_m) > kMostHeight_m + 0.27 * p.norm()) continue;
      samples.push_back(
          {ray.ray(), ray.inverse_m, camera.depth_sigma(z_m) * ray.inverse_m * ray.inverse_m});
    }
  return samples;
}

std::size_t count_near(const std::vector<Sample>& samples, const Eigen::Vector3d& a,
                       std::size_t stride) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < samples.size(); i += stride)
    n += std::abs(samples[i].inverse_m - a.dot(samples[i].ray)) < kGate_sigmas * samples[i].sigma
             ? stride
             : 0;
  return n;
}

// The plane with the most pixels on it, near the one on paper.
std::optional<Eigen::Vector3d> best_plane(const std::vector<Sample>& samples,
                                          const Eigen::Vector3d& up_camera, double height_m,
                                          std::mt19937_64* random) {
  if (samples.size() < kFewest) return std::nullopt;
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  std::size_t most = 0;
  const std::size_t stride = std::max<std::size_t>(1, samples.size() / 400);
  for (int i = 0; i < kTriples; ++i) {
    Eigen::Matrix3d rays;
    Eigen::Vector3d inverse;
    for (int k = 0; k < 3; ++k) {
      const Sample& s = samples[(*random)() % samples.size()];
      rays.row(k) = s.ray;
      inverse(k) = s.inverse_m;
    }
    if (std::abs(rays.determinant()) < 1e-3) continue;
    const Eigen::Vector3d a = rays.partialPivLu().solve(inverse);
    if (!plausible(a, up_camera, height_m)) continue;
    const std::size_t n = count_near(samples, a, stride);
    if (n > most) {
      most = n;
      best = a;
    }
  }
  if (most < kFewest) return std::nullopt;
  return best;
}

}  // namespace

std::int64_t block_of(std::int64_t utime_us) { return utime_us / kBlock_us; }
std::int64_t block_begin_us(std::int64_t block) { return block * kBlock_us; }

SE3 FloorView::T_level_camera() const {
  SE3 T = from_xyz_rpy(0.0, 0.0, height_m, roll_rad, pitch_rad, 0.0);
  T.linear() *= optical_to_body();
  return T;
}

FloorView floor_view_of(const SE3& T_base_camera) {
  FloorView view;
  view.height_m = T_base_camera.translation().z();
  // Up in the mounting's axes: Rx(-roll) * Ry(-pitch) * z.
  const Eigen::Vector3d up =
      optical_to_body() * T_base_camera.linear().transpose() * Eigen::Vector3d::UnitZ();
  view.pitch_rad = -std::asin(std::clamp(up.x(), -1.0, 1.0));
  view.roll_rad = std::atan2(up.y(), up.z());
  return view;
}

std::optional<FloorView> find_floor(const std::vector<DepthFrame>& frames,
                                    const CameraModel& camera, const SE3& T_base_camera) {
  const Eigen::Vector3d up = T_base_camera.linear().transpose() * Eigen::Vector3d::UnitZ();
  const double height_m = T_base_camera.translation().z();
  std::mt19937_64 random(1);
  struct Seen {
    std::int64_t block;
    std::vector<Sample> samples;
    Eigen::Vector3d a;
  };
  std::vector<Seen> seen;
  for (const DepthFrame& frame : frames) {
    Seen one{block_of(frame.utime_us), candidates(frame, camera, T_base_camera), {}};
    const auto a = best_plane(one.samples, up, height_m, &random);
    if (!a) continue;
    one.a = *a;
    seen.push_back(std::move(one));
  }
  if (seen.size() < kFewestFrames) return std::nullopt;
  // All frames see one plane: from the median of theirs to the common one.
  Eigen::Vector3d a;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    values.reserve(seen.size());
    for (const Seen& one : seen) values.push_back(one.a(k));
    std::nth_element(values.begin(),
                     values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    a(k) = values[values.size() / 2];
  }
  Eigen::Matrix3d covariance;
  FloorView view;
  for (int round = 0; round < kRounds; ++round) {
    BlockEquations<3> equations;
    view.n_frames = 0;
    for (const Seen& one : seen) {
      std::size_t n = 0;
      for (const Sample& s : one.samples) {
        const double r = a.dot(s.ray) - s.inverse_m;
        const double gate = (round == 0 ? 2.0 : 1.0) * kGate_sigmas * s.sigma;
        if (std::abs(r) > gate) continue;
        equations.add(one.block, s.ray, r, 1.0 / (s.sigma * s.sigma));
        ++n;
      }
      view.n_frames += n >= kFewest ? 1 : 0;
    }
    if (view.n_frames < kFewestFrames) return std::nullopt;
    a += equations.step();
    covariance = equations.covariance();
  }
  if (!plausible(a, up, height_m)) return std::nullopt;
  const auto numbers = [&](const Eigen::Vector3d& plane) {
    const Eigen::Vector3d up_body = optical_to_body() * (-plane.normalized());
    return Eigen::Vector3d(1.0 / plane.norm(), std::atan2(up_body.y(), up_body.z()),
                           -std::asin(std::clamp(up_body.x(), -1.0, 1.0)));
  };
  const Eigen::Vector3d n = numbers(a);
  view.height_m = n.x();
  view.roll_rad = n.y();
  view.pitch_rad = n.z();
  Eigen::Matrix3d J;
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 3; ++k)
    J.col(k) = (numbers(a + kStep * Eigen::Vector3d::Unit(k)) -
                numbers(a - kStep * Eigen::Vector3d::Unit(k))) /
               (2 * kStep);
  view.sigma = (J * covariance * J.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt();
  return view;
}

}  // namespace fusion_slam
