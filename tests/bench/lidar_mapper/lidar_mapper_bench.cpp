// Runs the LiDAR mapper's library over a recording, without a bus: trajectory, map picture, and
// where the time goes.
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>

#include <CLI/CLI.hpp>
#include <opencv2/imgcodecs.hpp>

#include "libs/datasets/carmen.hpp"
#include "libs/datasets/hokuyo.hpp"
#include "libs/submaps/grid_composer.hpp"
#include "services/lidar_mapper/lidar_mapper.hpp"

namespace fusion_slam {
namespace {

struct Odometry {
  std::int64_t utime_us;
  SE2 pose;
};

struct Recording {
  RobotModel robot;
  std::vector<LaserScan> scans;
  std::vector<Odometry> odometry;
};

Recording read_recording(const std::string& path, const std::string& format, bool use_odometry) {
  Recording r;
  r.robot.has_lidar = true;
  if (format == "hokuyo") {
    for (auto& record : read_mines_hokuyo(path).records) r.scans.push_back(std::move(record.scan));
    r.robot.lidar = {0.06, 4.0, 0.02, 10.0, 0.0};
    return r;
  }
  CarmenLog log = read_carmen(path);
  r.robot.T_base_lidar.translation().x() = log.front_laser_offset_m().value_or(0.0);
  for (auto& scan : log.scans) r.scans.push_back(std::move(scan.scan));
  if (use_odometry)
    for (const auto& o : log.raw_odometry()) r.odometry.push_back({o.utime_us, o.pose});
  r.robot.lidar = {0.1, 80.0, 0.03, 5.0, 0.0};
  return r;
}

class Picture {
 public:
  explicit Picture(double resolution_m) : composer_(resolution_m) {}

  void add(const MapperOutput& out) {
    if (out.node)
      for (const auto& m : out.node->submaps)
        if (m.submap_id == out.node->id) composer_.set_pose(m.submap_id, out.node->T_odom_base);
    add(out.tiles);
  }
  void add(const std::vector<Tile>& tiles) {
    for (const Tile& tile : tiles)
      if (const auto cells = decode_grid_tile(tile))
        composer_.set_tile(tile.key.submap_id, {tile.key.x, tile.key.y}, *cells, tile.resolution_m);
  }
  void write(const std::string& path) {
    composer_.recompose(true);
    const auto& tiles = composer_.map().tiles();
    if (tiles.empty()) return;
    TileIndex low = tiles.begin()->first, high = low;
    for (const auto& [index, cells] : tiles) {
      low = {std::min(low.first, index.first), std::min(low.second, index.second)};
      high = {std::max(high.first, index.first), std::max(high.second, index.second)};
    }
    cv::Mat image((high.second - low.second + 1) * kTileCells,
                  (high.first - low.first + 1) * kTileCells, CV_8UC1, cv::Scalar(205));
    for (const auto& [index, cells] : tiles)
      for (int y = 0; y < kTileCells; ++y)
        for (int x = 0; x < kTileCells; ++x) {
          const std::uint8_t cell = cells[static_cast<std::size_t>(y * kTileCells + x)];
          if (cell == kUnknownCell) continue;
          const int row = image.rows - 1 - ((index.second - low.second) * kTileCells + y);
          image.at<std::uint8_t>(row, (index.first - low.first) * kTileCells + x) =
              static_cast<std::uint8_t>(255 - cell);
        }
    cv::imwrite(path, image);
  }

 private:
  GridComposer composer_;
};

void write_tum(const std::string& path, const std::vector<LidarPose>& poses,
               const RobotModel& robot) {
  std::ofstream file(path);
  for (const LidarPose& pose : poses) {
    const SE3 T = to_se3(pose.T_odom_base) * robot.T_base_reference();
    const Eigen::Quaterniond q(T.linear());
    char line[256];
    std::snprintf(line, sizeof line, "%.6f %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n",
                  static_cast<double>(pose.utime_us) * 1e-6, T.translation().x(),
                  T.translation().y(), T.translation().z(), q.x(), q.y(), q.z(), q.w());
    file << line;
  }
}

void run(Recording& recording, const std::string& out) {
  LidarMapper mapper(recording.robot);
  Picture picture(recording.robot.map_resolution_m);
  std::vector<LidarPose> poses;
  std::vector<double> ms;
  std::size_t n_tiles = 0, tile_bytes = 0, next = 0;
  for (const LaserScan& scan : recording.scans) {
    while (next < recording.odometry.size() && recording.odometry[next].utime_us <= scan.utime_us) {
      mapper.add_odometry(recording.odometry[next].utime_us, recording.odometry[next].pose);
      ++next;
    }
    const auto before = std::chrono::steady_clock::now();
    const MapperOutput output = mapper.add_scan(scan);
    ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - before)
            .count());
    if (output.pose) poses.push_back(*output.pose);
    for (const Tile& tile : output.tiles) tile_bytes += tile.data.size();
    n_tiles += output.tiles.size();
    picture.add(output);
  }
  picture.add(mapper.finish());
  write_tum(out + ".tum", poses, recording.robot);
  picture.write(out + ".png");
  double total = 0.0;
  for (const double t : ms) total += t;
  std::sort(ms.begin(), ms.end());
  const MapperCounts& c = mapper.counts();
  std::printf(
      "%zu scans, %zu poses, %ld nodes, %ld weak, %ld lost, %ld restarts, %ld doubtful stamps, %ld "
      "repeated, "
      "%ld too empty\n%zu tiles, %.1f MB; per scan median %.2f ms, p95 %.2f, p99 %.2f, worst %.2f; "
      "sum %.2f s\n",
      ms.size(), poses.size(), c.nodes, c.weak, c.lost, c.restarts, c.doubtful_stamps, c.duplicates,
      c.unusable, n_tiles, static_cast<double>(tile_bytes) * 1e-6, ms[ms.size() / 2],
      ms[ms.size() * 95 / 100], ms[ms.size() * 99 / 100], ms.back(), total * 1e-3);
}

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  CLI::App app{"Runs the LiDAR mapper over a recording; writes OUT.tum and OUT.png"};
  std::string path, out = "out", format = "carmen";
  bool no_odometry = false;
  double resolution_m = 0.05;
  app.add_option("recording", path, "CARMEN log or Hokuyo text")->required();
  app.add_option("--out", out, "path of the results, without extension");
  app.add_option("--format", format, "carmen or hokuyo");
  app.add_option("--resolution", resolution_m, "of the map, m");
  app.add_flag("--no-odometry", no_odometry, "scans only");
  CLI11_PARSE(app, argc, argv);
  auto recording = fusion_slam::read_recording(path, format, !no_odometry);
  recording.robot.map_resolution_m = resolution_m;
  fusion_slam::run(recording, out);
  return 0;
}
