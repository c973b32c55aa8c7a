// What the bench runs the mapper over: files, and drawn buildings with exact truth.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "libs/datasets/carmen.hpp"
#include "libs/datasets/hokuyo.hpp"
#include "tests/services/lidar_mapper/building.hpp"

namespace fusion_slam {

struct BenchRecording {
  struct Odometry {
    std::int64_t utime_us;
    SE2 pose;
  };
  RobotModel robot;
  std::vector<LaserScan> scans;
  std::vector<Odometry> odometry;
  std::vector<SE2> truth;  // base, one a scan; empty: unknown
};

struct BenchChoice {
  std::string path;    // file, or the name of a scanner when simulated
  std::string format;  // carmen, hokuyo, building, corridor
  bool odometry = true;
  unsigned seed = 1;
};

inline BenchRecording simulate_recording(const BenchChoice& choice) {
  BenchRecording r;
  const auto all = scanners();
  const auto scanner =
      std::find_if(all.begin(), all.end(), [&](const Scanner& s) { return s.name == choice.path; });
  if (scanner == all.end()) throw std::runtime_error("no scanner is called " + choice.path);
  r.robot.has_lidar = true;
  r.robot.lidar = scanner->model;
  r.robot.T_base_lidar.translation().x() = 0.1;
  const double length_m = 40.0;
  const FlatWorld world = office_building(choice.seed, length_m, choice.format == "corridor");
  const Way way = round_of(length_m);
  std::mt19937 rng(choice.seed);
  std::normal_distribution<double> normal;
  SE2 odom;
  double odom_t = 0.0;
  for (double t = 0.0; t + 0.3 < way.duration_s(); t += 1.0 / scanner->model.rate_hz) {
    r.scans.push_back(scanner_sweep(world, *scanner, r.robot.T_base_lidar, way, t, rng));
    r.truth.push_back(way(t));
    if (!choice.odometry) continue;
    for (; odom_t <= t + 1e-9; odom_t += 0.05) {  // wheels: 2 % too long, slipping at random
      const SE2 step = way(odom_t).inverse() * way(odom_t + 0.05);
      r.odometry.push_back(
          {static_cast<std::int64_t>(std::llround(odom_t * 1e6)) + 1'000'000, odom});
      odom = odom * SE2{step.x * (1.02 + 0.05 * normal(rng)), step.y,
                        step.yaw * (1.02 + 0.1 * normal(rng)) + 0.0005 * normal(rng)};
    }
  }
  return r;
}

inline BenchRecording load_recording(const BenchChoice& choice) {
  if (choice.format == "building" || choice.format == "corridor") return simulate_recording(choice);
  BenchRecording r;
  r.robot.has_lidar = true;
  if (choice.format == "hokuyo") {
    for (auto& record : read_mines_hokuyo(choice.path).records)
      r.scans.push_back(std::move(record.scan));
    r.robot.lidar = {0.06, 4.0, 0.02, 10.0, 0.0000976};
    return r;
  }
  CarmenLog log = read_carmen(choice.path);
  r.robot.T_base_lidar.translation().x() = log.front_laser_offset_m().value_or(0.0);
  if (choice.odometry)
    for (const auto& o : log.raw_odometry()) r.odometry.push_back({o.utime_us, o.pose});
  for (auto& scan : log.scans) r.scans.push_back(std::move(scan.scan));
  r.robot.lidar = {0.05, 80.0, 0.02, 5.0, 0.0};
  return r;
}

}  // namespace fusion_slam
