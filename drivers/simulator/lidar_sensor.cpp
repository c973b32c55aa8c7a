#include "drivers/simulator/lidar_sensor.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/simulator/random.hpp"

namespace fusion_slam {
namespace {
constexpr std::uint64_t kLidarStream = 30;
}  // namespace

double return_probability(const LidarNoise& noise, double range_max_m, double range_m,
                          double cosine, double reflectance) {
  const double flat = (cosine - noise.lost_cosine) / (noise.sure_cosine - noise.lost_cosine);
  const double reach = range_max_m / std::max(1e-3, range_m);
  const double signal = reflectance / noise.white_reflectance * cosine * reach * reach;
  const double bright = (signal - (1.0 - noise.fade)) / (2.0 * noise.fade);
  return std::clamp(std::min(flat, bright), 0.0, 1.0);
}

LaserScan sweep(const Scene& scene, const RobotModel& robot, const LidarNoise& noise,
                const std::function<SE2(double)>& T_world_base, std::int64_t utime_us,
                std::uint64_t seed, std::int64_t index, bool with_noise) {
  LaserScan scan;
  scan.utime_us = utime_us;
  scan.rad0 = M_PI;
  scan.radstep = -2.0 * M_PI / kBeams;
  Random random(seed, kLidarStream, static_cast<std::uint64_t>(index));
  for (int i = 0; i < kBeams; ++i) {
    const SE3 T_world_lidar =
        to_se3(T_world_base(i * robot.lidar.beam_period_s)) * robot.T_base_lidar;
    const double angle = scan.rad0 + i * scan.radstep;
    const Eigen::Vector3d direction =
        T_world_lidar.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
    const double gaussian = random.gaussian();  // drawn for each beam, so that one beam's fate
    const double chance = random.uniform();     // does not change the others' noise
    double range = 0.0;
    if (const auto hit = scene.cast(T_world_lidar.translation(), direction)) {
      const double cosine = std::fabs(scene.normal(*hit).dot(direction));
      range = hit->t;
      const bool lost = with_noise && noise.with_dropouts &&
                        chance >= return_probability(noise, robot.lidar.range_max_m, range, cosine,
                                                     scene.reflectance(*hit));
      if (with_noise && noise.with_noise) range *= 1.0 + noise.range_fraction * gaussian;
      if (lost) range = 0.0;
      if (range < robot.lidar.range_min_m || range > robot.lidar.range_max_m) range = 0.0;
    }
    scan.ranges_m.push_back(static_cast<float>(range));
  }
  return scan;
}

}  // namespace fusion_slam
