// Dense mapper and fuser, as libraries, at exact poses: how good the maps are, what each keyframe
// costs, and how much is held in memory.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <random>
#include <set>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>

#include "libs/camera_messages/images.hpp"
#include "services/dense_mapper/dense_mapper.hpp"
#include "services/fuser/fuser.hpp"
#include "services/lidar_mapper/submap.hpp"
#include "tests/bench/dense_map/bench_log.hpp"
#include "tests/bench/dense_map/bench_score.hpp"
#include "tests/support/process_meter.hpp"

namespace fusion_slam {
namespace {

struct Choice {
  std::string log;
  std::string truth;
  std::string out = "dense_map";
  double distance_m = 0.2;
  double angle_rad = 0.2;
  double mount_pitch_deg = 0.0;
  double mount_roll_deg = 0.0;
  double pose_sigma_m = 0.0;
  int laps = 1;
  int move = 0;
};

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

void print_times(const char* what, std::vector<double> ms) {
  if (ms.empty()) return;
  std::sort(ms.begin(), ms.end());
  double sum = 0.0;
  for (const double t : ms) sum += t;
  std::printf("%-22s n %5zu  mean %7.2f  median %7.2f  p95 %7.2f  worst %7.2f ms  sum %.2f s\n",
              what, ms.size(), sum / static_cast<double>(ms.size()), ms[ms.size() / 2],
              ms[ms.size() * 95 / 100], ms.back(), sum * 1e-3);
}

class Bench {
 public:
  Bench(const Choice& choice, BenchLog log)
      : choice_(choice), log_(std::move(log)), random_(1), submaps_(0.05, LidarMapperConfig{}) {
    RobotModel robot = log_.robot;  // what the mapper believes; the images are from the true one
    robot.T_base_camera =
        from_xyz_rpy(robot.T_base_camera.translation().x(), robot.T_base_camera.translation().y(),
                     robot.T_base_camera.translation().z(), 0, 0, 0) *
        from_xyz_rpy(0, 0, 0, choice.mount_roll_deg * M_PI / 180,
                     choice.mount_pitch_deg * M_PI / 180, 0) *
        SE3(robot.T_base_camera.linear());
    mapper_ = std::make_unique<DenseMapper>(log_.camera, robot, DenseMapperConfig{});
    fuser_ = std::make_unique<Fuser>(robot.map_resolution_m, FuserConfig{});
  }

  void run() {
    const std::int64_t length_us =
        log_.T_world_base.rbegin()->first - log_.T_world_base.begin()->first + 100'000;
    for (int lap = 0; lap < choice_.laps; ++lap) {
      std::size_t scan = 0;
      for (const BenchLog::Image& image : log_.keyframes) {
        for (; scan < log_.scans.size() && log_.scans[scan].utime_us <= image.utime_us; ++scan)
          add_scan(log_.scans[scan], lap * length_us);
        add_keyframe(image, lap * length_us);
      }
      for (; scan < log_.scans.size(); ++scan) add_scan(log_.scans[scan], lap * length_us);
      if (choice_.laps > 1)
        std::printf("lap %d: %.0f s, %zu keyframes, RSS %.1f MB\n", lap + 1,
                    log_.seconds * (lap + 1), mapper_->integrated(), resident_mb());
    }
    finish();
  }

  // What a loop closure does: the graph moves some submaps, evenly picked; cloud, OctoMap and
  // raster follow. Not scored: the map is wrong afterwards.
  void move_submaps() {
    if (choice_.move < 1) return;
    const std::int64_t per = DenseMapperConfig{}.keyframes_per_submap;
    const std::int64_t submaps = (keyframe_ + per - 1) / per;
    const std::int64_t n = std::min<std::int64_t>(choice_.move, submaps);
    for (std::int64_t i = 0; i < n; ++i) {
      const std::int64_t first = 1 + per * (i * submaps / n);
      const SE3 T_new_old = from_xyz_rpy(0.1, 0.05, 0, 0, 0, M_PI / 180);
      for (std::int64_t id = first; id < first + per && id <= keyframe_; ++id) {
        const std::int64_t utime_us = log_.keyframes[static_cast<std::size_t>(id - 1)].utime_us;
        mapper_->set_pose(id, T_new_old * log_.pose_at(utime_us),
                          log_.T_world_base.rbegin()->first + 10'000'000);
      }
    }
    const double before = cpu_ms();
    const DenseTiles grid = mapper_->update_grid(false);
    const double grid_ms = cpu_ms() - before;
    const DenseTiles maps = mapper_->update_maps();
    std::printf(
        "%ld of %ld submaps moved by 0.11 m and 1 degree: raster after %.0f ms of CPU (%zu tiles), "
        "OctoMap and cloud after %.0f ms (%zu and %zu tiles)\n",
        static_cast<long>(n), static_cast<long>(submaps), grid_ms, grid.grid.size(),
        cpu_ms() - before, maps.octomap.size(), maps.cloud.size());
  }

  void report() {
    const MapRaster lidar = lidar_.raster(0.05), visual = visual_.raster(0.05),
                    fused = fused_.raster(0.05);
    print_times("decode", decode_ms_);
    print_times("dense: add + integrate", integrate_ms_);
    print_times("dense: raster", update_ms_);
    print_times("dense: octomap, cloud", maps_ms_);
    print_times("fuser", fuser_ms_);
    std::printf(
        "%zu keyframes in %.1f s; %zu grid, %zu octomap, %zu cloud tiles sent, %.1f MB; RSS %.1f "
        "MB\n",
        log_.keyframes.size(), log_.seconds, n_grid_, n_octomap_, n_cloud_,
        static_cast<double>(bytes_) * 1e-6, resident_mb());
    std::printf(
        "kept packed: submaps %.2f MB, composed map %.2f MB; mounting off by %.2f deg, %.1f mm\n",
        static_cast<double>(mapper_->submap_bytes()) * 1e-6,
        static_cast<double>(mapper_->map_bytes()) * 1e-6,
        log_so3(mapper_->mounting_correction().linear()).norm() * 180 / M_PI,
        mapper_->mounting_correction().translation().z() * 1e3);
    if (choice_.truth.empty()) return;
    const Eigen::Vector3d start = log_.T_world_base.begin()->second.translation();
    const TruthMap truth = load_truth(choice_.truth, log_.robot, start.head<2>());
    const std::pair<const char*, const MapRaster*> maps[] = {
        {"lidar", &lidar}, {"camera", &visual}, {"fused", &fused}};
    for (const auto& [name, map] : maps) {
      std::cout << score_line(name, truth, *map, visual, SE2{}) << "\n"
                << measured_line(name, truth, *map, measured_) << "\n";
      if (!map->probability.empty()) write_pictures(choice_.out + "_" + name, truth, *map, SE2{});
    }
  }

 private:
  void add_keyframe(const BenchLog::Image& image, std::int64_t later_us) {
    double before = cpu_ms();
    std::string why;
    auto frame = from_message(image.message, &why);
    decode_ms_.push_back(cpu_ms() - before);
    if (!frame) throw std::runtime_error(why);
    if (!choice_.truth.empty()) measure(frame->depth_mm, log_.pose_at(image.utime_us));
    frame->utime_us += later_us;
    const std::int64_t id = ++keyframe_;
    before = cpu_ms();
    mapper_->add_keyframe(id, *frame);
    SE3 T = log_.pose_at(image.utime_us);
    std::normal_distribution<double> normal(0.0, choice_.pose_sigma_m);
    T.translation() += Eigen::Vector3d(normal(random_), normal(random_), 0.0);
    mapper_->set_pose(id, T, frame->utime_us);
    mapper_->integrate_ready();
    integrate_ms_.push_back(cpu_ms() - before);
    if (mapper_->due()) publish(false);
  }

  // Cells of the band in which the camera measured something, as far as it measures at all.
  void measure(const cv::Mat& depth_mm, const SE3& T_world_base) {
    const SE3 T_world_camera = T_world_base * log_.robot.T_base_camera;
    for (int v = 0; v < depth_mm.rows; v += 4)
      for (int u = 0; u < depth_mm.cols; u += 4) {
        const double z_m = depth_mm.at<std::uint16_t>(v, u) * 1e-3;
        if (!log_.camera.depth_valid(z_m)) continue;
        const Eigen::Vector3d p = T_world_camera * log_.camera.unproject(u, v, z_m);
        if (p.z() >= log_.robot.floor_clearance_m && p.z() <= log_.robot.robot_height_m)
          measure(p.head<2>());
      }
  }
  void measure(const Eigen::Vector2d& p_m) {
    const double cell_m = log_.robot.map_resolution_m;
    measured_.emplace(static_cast<int>(std::floor(p_m.x() / cell_m)),
                      static_cast<int>(std::floor(p_m.y() / cell_m)));
  }

  void publish(bool exact) {
    double before = cpu_ms();
    DenseTiles tiles = mapper_->update_grid(exact);
    update_ms_.push_back(cpu_ms() - before);
    before = cpu_ms();
    const DenseTiles maps = mapper_->update_maps();
    maps_ms_.push_back(cpu_ms() - before);
    tiles.octomap = maps.octomap;
    tiles.cloud = maps.cloud;
    n_grid_ += tiles.grid.size();
    n_octomap_ += tiles.octomap.size();
    n_cloud_ += tiles.cloud.size();
    for (const auto* list : {&tiles.grid, &tiles.octomap, &tiles.cloud})
      for (const Tile& tile : *list) bytes_ += tile.data.size();
    visual_.take(tiles.grid);
    before = cpu_ms();
    for (const Tile& tile : tiles.grid) fuser_->add_visual_tile(tile);
    fuse(exact, before);
  }

  void fuse(bool exact, double before) {
    if (exact || fuser_->due()) {
      const FuserOutput output = fuser_->update(exact);
      lidar_.take(output.lidar);
      fused_.take(output.fused);
    }
    fuser_ms_.push_back(cpu_ms() - before);
  }

  // Nodes as the LiDAR mapper makes them.
  void add_scan(const LaserScan& scan, std::int64_t later_us) {
    const LidarMapperConfig config;
    const SE2 T = to_se2(log_.pose_at(scan.utime_us));
    if (node_ > 0) {
      const SE2 moved = T_world_node_.inverse() * T;
      if (std::hypot(moved.x, moved.y) < config.node_distance_m &&
          std::abs(moved.yaw) < config.node_angle_rad)
        return;
    }
    T_world_node_ = T;
    ++node_;
    const std::int64_t later = scan.utime_us + 100'000;
    SE2 motion = T.inverse() * to_se2(log_.pose_at(later));
    const ScanPoints points = read_scan(scan, log_.robot, Twist::from_motion(motion, 0.1), 30.0);
    if (!choice_.truth.empty())
      for (const auto& p : points.hits_base)
        measure((to_se3(T) * Eigen::Vector3d(p.x(), p.y(), 0.0)).head<2>());
    std::vector<Tile> tiles = submaps_.insert(node_, points, T, scan.utime_us + later_us);
    for (const auto& member : submaps_.inserted_into())
      if (member.submap_id == node_) fuser_->set_anchor(node_, to_se3(T), scan.utime_us);
    if (node_ % config.nodes_per_publication == 0) {
      const auto more = submaps_.take_changed_tiles();
      tiles.insert(tiles.end(), more.begin(), more.end());
    }
    take_submap_tiles(tiles, false);
  }
  void take_submap_tiles(const std::vector<Tile>& tiles, bool exact) {
    const double before = cpu_ms();
    for (const Tile& tile : tiles) fuser_->add_submap_tile(tile);
    fuse(exact, before);
  }

  void finish() {
    publish(true);
    take_submap_tiles(submaps_.finish_all(), true);
  }

  Choice choice_;
  BenchLog log_;
  std::mt19937 random_;
  std::unique_ptr<DenseMapper> mapper_;
  std::unique_ptr<Fuser> fuser_;
  ActiveSubmaps submaps_;
  std::set<std::pair<int, int>> measured_;  // world cells
  std::int64_t keyframe_ = 0;
  std::int64_t node_ = 0;
  SE2 T_world_node_;
  HeldGrid lidar_, visual_, fused_;
  std::vector<double> decode_ms_, integrate_ms_, update_ms_, maps_ms_, fuser_ms_;
  std::size_t n_grid_ = 0, n_octomap_ = 0, n_cloud_ = 0, bytes_ = 0;
};

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  CLI::App app{"Dense mapper and fuser at exact poses: quality, time and memory"};
  fusion_slam::Choice choice;
  app.add_option("log", choice.log, "an LCM log with GROUND_TRUTH")->required();
  app.add_option("--truth", choice.truth, "world file, or a folder with map.yaml and classes.pgm");
  app.add_option("--out", choice.out, "where pictures go: OUT_fused.png ...");
  app.add_option("--distance", choice.distance_m, "a keyframe every so many metres");
  app.add_option("--angle", choice.angle_rad, "or so many radians");
  app.add_option("--mount-pitch", choice.mount_pitch_deg,
                 "error of the camera's mounting, degrees");
  app.add_option("--mount-roll", choice.mount_roll_deg, "likewise");
  app.add_option("--pose-sigma", choice.pose_sigma_m, "noise of the keyframes' poses");
  app.add_option("--laps", choice.laps, "the recording again and again: memory");
  app.add_option("--move", choice.move, "at the end: move so many submaps, as a loop closure does");
  CLI11_PARSE(app, argc, argv);
  try {
    fusion_slam::Bench bench(
        choice, fusion_slam::read_bench_log(choice.log, choice.distance_m, choice.angle_rad));
    bench.run();
    bench.report();
    bench.move_submaps();
  } catch (const std::exception& e) {
    std::cerr << e.what() << "\n";
    return 1;
  }
  return 0;
}
