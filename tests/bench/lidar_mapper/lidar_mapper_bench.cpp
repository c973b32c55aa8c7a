// Runs the LiDAR mapper's library over a recording, without a bus: trajectory, map picture, and
// where the time goes.
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <map>
#include <string>

#include <CLI/CLI.hpp>
#include <Eigen/Eigenvalues>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "libs/grid/grid_mosaic.hpp"
#include "services/lidar_mapper/lidar_mapper.hpp"
#include "tests/bench/lidar_mapper/bench_recording.hpp"

namespace fusion_slam {
namespace {

class Picture {
 public:
  explicit Picture(double resolution_m) : mosaic_(resolution_m) {}

  void add(const MapperOutput& out) {
    if (out.node)
      for (const auto& m : out.node->submaps)
        if (m.submap_id == out.node->id) mosaic_.set_pose(m.submap_id, out.node->T_odom_base);
    add(out.tiles);
    if (out.node && out.node->id % 12 == 0)
      marks_.push_back({out.node->T_odom_base, out.node->covariance});
  }
  void draw_ellipses() { ellipses_ = true; }
  void add(const std::vector<Tile>& tiles) {
    for (const Tile& tile : tiles)
      if (const auto cells = decode_grid_tile(tile))
        mosaic_.set_tile(tile.key.submap_id, {tile.key.x, tile.key.y}, *cells, tile.resolution_m);
  }
  void write(const std::string& path) {
    mosaic_.recompose(true);
    const auto& tiles = mosaic_.map().tiles();
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
    if (!ellipses_) {
      cv::imwrite(path, image);
      return;
    }
    cv::Mat colour;
    cv::cvtColor(image, colour, cv::COLOR_GRAY2BGR);
    const double cell_m = mosaic_.map().resolution_m();
    for (const Mark& mark : marks_) {
      const Eigen::Matrix2d R = Eigen::Rotation2Dd(mark.T_odom_base.yaw).toRotationMatrix();
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(
          R * mark.covariance.topLeftCorner<2, 2>() * R.transpose());
      const Eigen::Vector2d longest = eigen.eigenvectors().col(1);
      const cv::Point2d centre(mark.T_odom_base.x / cell_m - low.first * kTileCells,
                               image.rows - mark.T_odom_base.y / cell_m + low.second * kTileCells);
      const auto axis = [&](int i) {
        return std::max(1.0, kMagnified * std::sqrt(eigen.eigenvalues()[i]) / cell_m);
      };
      cv::ellipse(colour, centre, cv::Size2d(axis(1), axis(0)),
                  -std::atan2(longest.y(), longest.x()) * 180.0 / M_PI, 0, 360,
                  cv::Scalar(40, 40, 220), 1, cv::LINE_AA);
    }
    cv::imwrite(path, colour);
  }

 private:
  // One sigma of T_previous_base, so many times as large.
  static constexpr double kMagnified = 25.0;
  struct Mark {
    SE2 T_odom_base;
    Eigen::Matrix3d covariance;
  };
  std::vector<Mark> marks_;
  bool ellipses_ = false;
  GridMosaic mosaic_;
};

void write_pose(std::ofstream& file, std::int64_t utime_us, const SE3& T) {
  const Eigen::Quaterniond q(T.linear());
  char line[256];
  std::snprintf(line, sizeof line, "%.6f %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n",
                static_cast<double>(utime_us) * 1e-6, T.translation().x(), T.translation().y(),
                T.translation().z(), q.x(), q.y(), q.z(), q.w());
  file << line;
}

// CPU time of this thread: other programs on the machine don't count.
double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

// Are the nodes' covariances what they claim? For a right one xi^T C^-1 xi is 3 on average, and
// each axis' error is one sigma.
struct Consistency {
  int n = 0;
  double nees = 0.0;
  Eigen::Vector3d squared = Eigen::Vector3d::Zero();  // in sigmas
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();      // of errors, m, m, rad
  Eigen::Vector3d squared_m = Eigen::Vector3d::Zero();
  std::map<std::int64_t, SE2> truth_of;  // by node

  void add(const LidarNode& node, const SE2& truth) {
    truth_of[node.id] = truth;
    const auto before = truth_of.find(node.previous_id);
    if (before == truth_of.end()) return;
    const SE2 expected = before->second.inverse() * truth;
    const SE2 error = expected.inverse() * node.T_previous_base;
    const Eigen::Vector3d xi(error.x, error.y, error.yaw);
    nees += xi.dot(node.covariance.inverse() * xi);
    squared += (xi.array().square() / node.covariance.diagonal().array()).matrix();
    squared_m += xi.array().square().matrix();
    sum += xi;
    ++n;
  }
  void print() const {
    if (n == 0) return;
    const Eigen::Vector3d s = (squared / n).cwiseSqrt(), e = (squared_m / n).cwiseSqrt();
    std::printf(
        "node to node over %d: NEES %.2f (3 is right); error/sigma %.2f %.2f %.2f; rms error "
        "%.2f mm %.2f mm %.3f deg; bias %.2f mm %.2f mm %.4f deg\n",
        n, nees / n, s.x(), s.y(), s.z(), 1e3 * e.x(), 1e3 * e.y(), e.z() * 180 / M_PI,
        1e3 * sum.x() / n, 1e3 * sum.y() / n, sum.z() / n * 180 / M_PI);
  }
};

void run(BenchRecording& recording, const std::string& out) {
  LidarMapper mapper(recording.robot);
  Picture picture(recording.robot.map_resolution_m);
  Consistency consistency;
  std::ofstream tum(out + ".tum");
  std::vector<double> ms;
  std::size_t n_tiles = 0, tile_bytes = 0, next = 0, n_poses = 0;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const LaserScan& scan = recording.scans[i];
    while (next < recording.odometry.size() && recording.odometry[next].utime_us <= scan.utime_us) {
      mapper.add_odometry(recording.odometry[next].utime_us, recording.odometry[next].pose);
      ++next;
    }
    const double before = cpu_ms();
    const MapperOutput output = mapper.add_scan(scan);
    ms.push_back(cpu_ms() - before);
    if (output.pose) {
      ++n_poses;
      write_pose(tum, output.pose->utime_us,
                 to_se3(output.pose->T_odom_base) * recording.robot.T_base_reference());
    }
    if (output.node && !recording.truth.empty()) consistency.add(*output.node, recording.truth[i]);
    for (const Tile& tile : output.tiles) tile_bytes += tile.data.size();
    n_tiles += output.tiles.size();
    picture.add(output);
  }
  picture.add(mapper.finish());
  if (!recording.truth.empty()) picture.draw_ellipses();
  picture.write(out + ".png");
  if (!recording.truth.empty()) {
    std::ofstream truth(out + "_truth.tum");
    for (std::size_t i = 0; i < recording.truth.size(); ++i)
      write_pose(truth, recording.scans[i].utime_us, to_se3(recording.truth[i]));
  }
  double total = 0.0;
  for (const double t : ms) total += t;
  std::sort(ms.begin(), ms.end());
  const MapperCounts& c = mapper.counts();
  std::printf(
      "%zu scans, %zu poses, %ld nodes, %ld weak, %ld lost, %ld restarts, %ld doubtful stamps, %ld "
      "repeated, %ld too empty\n%zu tiles, %.1f MB; CPU per scan median %.2f ms, p95 %.2f, p99 "
      "%.2f, "
      "worst %.2f; sum %.2f s\n",
      ms.size(), n_poses, c.nodes, c.weak, c.lost, c.restarts, c.doubtful_stamps, c.duplicates,
      c.unusable, n_tiles, static_cast<double>(tile_bytes) * 1e-6, ms[ms.size() / 2],
      ms[ms.size() * 95 / 100], ms[ms.size() * 99 / 100], ms.back(), total * 1e-3);
  consistency.print();
}

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  CLI::App app{
      "Runs the LiDAR mapper over a recording; writes OUT.tum, OUT.png and, where the truth "
      "is known, OUT_truth.tum"};
  std::string out = "out";
  fusion_slam::BenchChoice choice;
  choice.format = "carmen";
  bool no_odometry = false;
  double resolution_m = 0.05;
  app.add_option("recording", choice.path,
                 "CARMEN log, Hokuyo text, or for a drawn world the scanner: sick, sick-half, "
                 "rplidar, hokuyo, utm")
      ->required();
  app.add_option("--out", out, "path of the results, without extension");
  app.add_option("--format", choice.format, "carmen, hokuyo, building or corridor")
      ->check(CLI::IsMember({"carmen", "hokuyo", "building", "corridor"}));
  app.add_option("--seed", choice.seed, "of the drawn world");
  app.add_option("--resolution", resolution_m, "of the map, m");
  app.add_flag("--no-odometry", no_odometry, "scans only");
  CLI11_PARSE(app, argc, argv);
  choice.odometry = !no_odometry;
  try {
    auto recording = fusion_slam::load_recording(choice);
    recording.robot.map_resolution_m = resolution_m;
    fusion_slam::run(recording, out);
  } catch (const std::exception& e) {
    std::cerr << e.what() << "\n";
    return 1;
  }
  return 0;
}
