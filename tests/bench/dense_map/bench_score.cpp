#include "tests/bench/dense_map/bench_score.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "drivers/simulator/world.hpp"
#include "libs/evaluation/map_score.hpp"
#include "libs/maps/ros_map_reader.hpp"

namespace fusion_slam {
namespace {

bool occupied_near(const ResampledMap& map, int column, int row) {
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (map.at(column + dx, row + dy) == CellState::kOccupied) return true;
  return false;
}
bool known_near(const ResampledMap& map, int column, int row) {
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (map.at(column + dx, row + dy) != CellState::kUnknown) return true;
  return false;
}
bool truth_near(const TruthMap& truth, int column, int row) {
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const int x = column + dx, y = row + dy;
      if (x < 0 || y < 0 || x >= truth.raster.width || y >= truth.raster.height) continue;
      if (truth.classes[truth.raster.index(x, y)] != 0) return true;
    }
  return false;
}

}  // namespace

void HeldGrid::take(const std::vector<Tile>& tiles) {
  for (const Tile& tile : tiles) {
    const TileIndex index{tile.key.x, tile.key.y};
    if (tile.encoding == TileEncoding::kEmpty) {
      tiles_.erase(index);
    } else if (const auto fused = decode_fused_tile(tile)) {
      tiles_[index] = *fused;
    } else if (const auto cells = decode_grid_tile(tile)) {
      tiles_[index].probability = *cells;
    }
  }
}

MapRaster HeldGrid::raster(double resolution_m) const {
  std::string why;
  auto raster = make_raster(tiles_, resolution_m, &why);
  return raster ? *raster : MapRaster{};
}

TruthMap load_truth(const std::filesystem::path& path, const RobotModel& robot,
                    const Eigen::Vector2d& start_m) {
  if (!std::filesystem::is_directory(path)) {
    const World world = load_world(path);
    return make_truth_map(world.boxes, {}, start_m, truth_options_for(robot));
  }
  TruthMap truth;
  truth.raster = read_ros_map(path / "map.yaml");
  truth.classes = read_grey(path / "classes.pgm").values;
  return truth;
}

std::string score_line(const std::string& name, const TruthMap& truth, const MapRaster& map,
                       const MapRaster& visual, const SE2& T_world_map) {
  if (map.probability.empty()) return name + ": empty";
  const auto on_truth = resample(truth.raster, map, T_world_map);
  if (!on_truth) return name + ": " + on_truth.problem;
  const MapScore score = score_map(truth.raster, truth.classes, *on_truth, 1);
  std::size_t far_walls = 0;
  std::size_t far_found = 0;
  if (!visual.probability.empty()) {
    const auto seen = resample(truth.raster, visual, T_world_map);
    for (int row = 0; row < truth.raster.height; ++row)
      for (int column = 0; column < truth.raster.width; ++column) {
        if (truth.classes[truth.raster.index(column, row)] !=
                static_cast<std::uint8_t>(ObstacleClass::kWall) ||
            known_near(*seen, column, row))
          continue;
        ++far_walls;
        far_found += occupied_near(*on_truth, column, row) ? 1 : 0;
      }
  }
  char text[400];
  const auto& by = score.by_class;
  const auto of = [&](ObstacleClass c) { return by[static_cast<std::size_t>(c)].recall(); };
  std::snprintf(
      text, sizeof text,
      "%-7s F1 %.3f  precision %.3f (wrong: %zu in free, %zu in unknown)  recall %.3f | "
      "wall %.3f other %.3f chair %.3f table %.3f low box %.3f | walls out of the "
      "camera's reach %.3f of %zu | free: accuracy %.4f coverage %.3f",
      name.c_str(), score.f1(), score.precision(), score.false_in_free, score.false_in_unknown,
      score.recall(), of(ObstacleClass::kWall), of(ObstacleClass::kOther),
      of(ObstacleClass::kChair), of(ObstacleClass::kTable), of(ObstacleClass::kLowBox),
      far_walls == 0 ? 0.0 : static_cast<double>(far_found) / static_cast<double>(far_walls),
      far_walls, score.free_accuracy(), score.free_coverage());
  return text;
}

std::string measured_line(const std::string& name, const TruthMap& truth, const MapRaster& map,
                          const std::set<std::pair<int, int>>& measured) {
  const auto on_truth = resample(truth.raster, map, SE2{});
  if (!on_truth) return name + ": " + on_truth.problem;
  const int x0 = static_cast<int>(std::lround(truth.raster.origin_x_m / truth.raster.resolution_m));
  const int y0 = static_cast<int>(std::lround(truth.raster.origin_y_m / truth.raster.resolution_m));
  const auto measured_near = [&](int column, int row) {
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if (measured.count({x0 + column + dx, y0 + row + dy}) != 0) return true;
    return false;
  };
  std::array<ClassScore, kObstacleClasses> by_class{};
  std::size_t occupied = 0;
  for (int row = 0; row < truth.raster.height; ++row)
    for (int column = 0; column < truth.raster.width; ++column) {
      const std::uint8_t what = truth.classes[truth.raster.index(column, row)];
      if (what == 0 || what >= kObstacleClasses) continue;
      ++occupied;
      if (!measured_near(column, row)) continue;
      const std::size_t found = occupied_near(*on_truth, column, row) ? 1 : 0;
      for (const std::size_t i : {std::size_t{0}, std::size_t{what}}) {
        ++by_class[i].cells;
        by_class[i].found += found;
      }
    }
  const double recall = by_class[0].recall();
  const double precision = score_map(truth.raster, truth.classes, *on_truth, 1).precision();
  char text[300];
  std::snprintf(
      text, sizeof text,
      "%-7s of the %zu of %zu occupied cells that a sensor measured: recall %.3f, F1 %.3f "
      "| wall %.3f other %.3f chair %.3f table %.3f low box %.3f",
      name.c_str(), by_class[0].cells, occupied, recall,
      recall + precision == 0.0 ? 0.0 : 2 * recall * precision / (recall + precision),
      by_class[1].recall(), by_class[2].recall(), by_class[3].recall(), by_class[4].recall(),
      by_class[5].recall());
  return text;
}

void write_pictures(const std::filesystem::path& prefix, const TruthMap& truth,
                    const MapRaster& map, const SE2& T_world_map) {
  const auto on_truth = resample(truth.raster, map, T_world_map);
  if (!on_truth) return;
  const int width = truth.raster.width;
  const int height = truth.raster.height;
  cv::Mat truth_picture(height, width, CV_8UC3);
  cv::Mat map_picture(height, width, CV_8UC3);
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      const std::size_t i = truth.raster.index(column, row);
      const CellState is = state_of_cell(truth.raster.probability[i]);
      const CellState says = on_truth->at(column, row);
      const auto grey = [](CellState state) {
        const std::uint8_t v = state == CellState::kOccupied     ? 0
                               : state == CellState::kUnoccupied ? 255
                                                                 : 160;
        return cv::Vec3b(v, v, v);
      };
      cv::Vec3b colour = grey(says);
      if (says == CellState::kOccupied && !truth_near(truth, column, row)) colour = {40, 40, 230};
      if (is == CellState::kOccupied && !occupied_near(*on_truth, column, row))
        colour = {240, 140, 30};
      truth_picture.at<cv::Vec3b>(height - 1 - row, column) = grey(is);
      map_picture.at<cv::Vec3b>(height - 1 - row, column) = colour;
    }
  cv::Mat both;
  cv::hconcat(truth_picture, map_picture, both);
  cv::resize(both, both, {}, 4, 4, cv::INTER_NEAREST);
  cv::imwrite(prefix.string() + ".png", both);
}

}  // namespace fusion_slam
