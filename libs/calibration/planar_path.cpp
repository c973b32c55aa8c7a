#include "libs/calibration/planar_path.hpp"

#include <algorithm>

namespace fusion_slam {

void PlanarPath::add(std::int64_t utime_us, const SE2& T_odom_body) {
  if (!times_us_.empty() && utime_us <= times_us_.back()) return;
  double yaw = T_odom_body.yaw;
  if (!poses_.empty()) yaw = poses_.back().z() + wrap_angle(yaw - poses_.back().z());
  times_us_.push_back(utime_us);
  poses_.emplace_back(T_odom_body.x, T_odom_body.y, yaw);
}

std::size_t PlanarPath::segment(double utime_us) const {
  const auto next =
      std::upper_bound(times_us_.begin(), times_us_.end(), utime_us,
                       [](double t, std::int64_t u) { return t < static_cast<double>(u); });
  const auto i = static_cast<std::size_t>(next - times_us_.begin());
  return std::clamp<std::size_t>(i, 1, times_us_.size() - 1) - 1;
}

bool PlanarPath::knows(double utime_us) const {
  if (size() < 2 || utime_us < static_cast<double>(begin_us()) ||
      utime_us > static_cast<double>(end_us()))
    return false;
  const std::size_t i = segment(utime_us);
  return times_us_[i + 1] - times_us_[i] <= kGap_us;
}

Eigen::Vector3d PlanarPath::slope(std::size_t i) const {
  const std::size_t a = i == 0 ? 0 : i - 1;
  const std::size_t b = std::min(i + 1, size() - 1);
  const auto seconds = [&](std::size_t from, std::size_t to) {
    return 1e-6 * static_cast<double>(times_us_[to] - times_us_[from]);
  };
  if (a == i || b == i) return (poses_[b] - poses_[a]) / seconds(a, b);
  // The parabola through the three: right also for uneven times.
  const double before = seconds(a, i);
  const double after = seconds(i, b);
  const Eigen::Vector3d left = (poses_[i] - poses_[a]) / before;
  const Eigen::Vector3d right = (poses_[b] - poses_[i]) / after;
  return (left * after + right * before) / (before + after);
}

Eigen::Vector3d PlanarPath::cubic(double utime_us, bool derivative) const {
  const std::size_t i = segment(utime_us);
  const double h_s = 1e-6 * static_cast<double>(times_us_[i + 1] - times_us_[i]);
  const double u = 1e-6 * (utime_us - static_cast<double>(times_us_[i])) / h_s;
  const Eigen::Vector3d& a = poses_[i];
  const Eigen::Vector3d& b = poses_[i + 1];
  const Eigen::Vector3d va = slope(i) * h_s;
  const Eigen::Vector3d vb = slope(i + 1) * h_s;
  if (derivative)
    return ((6 * u * u - 6 * u) * (a - b) + (3 * u * u - 4 * u + 1) * va +
            (3 * u * u - 2 * u) * vb) /
           h_s;
  return (2 * u * u * u - 3 * u * u + 1) * a + (u * u * u - 2 * u * u + u) * va +
         (3 * u * u - 2 * u * u * u) * b + (u * u * u - u * u) * vb;
}

SE2 PlanarPath::at(double utime_us) const {
  const Eigen::Vector3d p = cubic(utime_us, false);
  return {p.x(), p.y(), wrap_angle(p.z())};
}

Eigen::Vector3d PlanarPath::velocity(double utime_us) const { return cubic(utime_us, true); }

}  // namespace fusion_slam
