#include "drivers/simulator/truth_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace fusion_slam {
namespace {

constexpr std::uint8_t kOccupiedByte = 255;
constexpr std::uint8_t kFreeByte = 1;
constexpr int kSlices = 64;        // of the band's height, one bit each
constexpr double kTouch_m = 1e-6;  // a solid must reach this far into a cell to fill it
constexpr double kMaxCells = 1 << 27;

// For each cell: which slices of the band are filled, and by what.
struct Columns {
  MapRaster raster;  // geometry only
  std::vector<std::uint64_t> filled;
  std::vector<std::uint8_t> classes;
};

Columns empty_columns(const std::vector<Footprint>& footprints, const Eigen::Vector2d& start_m,
                      double resolution_m) {
  Eigen::Vector2d low = start_m, high = start_m;
  for (const Footprint& footprint : footprints)
    for (const Eigen::Vector3d& p : footprint.outline_m) {
      low = low.cwiseMin(p.head<2>());
      high = high.cwiseMax(p.head<2>());
    }
  const Eigen::Array2d first = (low / resolution_m).array().floor() - 1.0;
  const Eigen::Array2d cells = (high / resolution_m).array().ceil() + 1.0 - first;
  if (!(cells.prod() <= kMaxCells))
    throw std::runtime_error("the true map would be " + std::to_string(cells[0]) + " x " +
                             std::to_string(cells[1]) + " cells; choose a coarser resolution");
  Columns columns;
  columns.raster.resolution_m = resolution_m;
  columns.raster.origin_x_m = first[0] * resolution_m;
  columns.raster.origin_y_m = first[1] * resolution_m;
  columns.raster.width = static_cast<int>(cells[0]);
  columns.raster.height = static_cast<int>(cells[1]);
  columns.filled.assign(static_cast<std::size_t>(cells.prod()), 0);
  columns.classes.assign(columns.filled.size(), 0);
  return columns;
}

std::uint64_t slices_between(double low_m, double high_m, const HeightBand& band) {
  const double per_m = kSlices / (band.high_m - band.low_m);
  const int from = std::clamp(int(std::floor((low_m - band.low_m) * per_m)), 0, kSlices - 1);
  const int to = std::clamp(int(std::ceil((high_m - band.low_m) * per_m)) - 1, from, kSlices - 1);
  const int n = to - from + 1;
  return (n == kSlices ? ~std::uint64_t{0} : (std::uint64_t{1} << n) - 1) << from;
}

// Some kSightGap_m of the column are open.
bool sight_passes(std::uint64_t filled, const HeightBand& band) {
  const int needed =
      static_cast<int>(std::ceil(kSightGap_m * kSlices / (band.high_m - band.low_m)));
  int open = 0;
  for (int i = 0; i < kSlices; ++i) {
    open = (filled >> i & 1U) != 0 ? 0 : open + 1;
    if (open >= needed) return true;
  }
  return false;
}

// Every cell that the footprint reaches into: first cut into rows, then into cells.
void fill(const Footprint& footprint, const HeightBand& band, Columns* columns) {
  const MapRaster& raster = columns->raster;
  const double slack_m = footprint.surface ? 0.0 : kTouch_m;
  const auto cell_range = [&](const std::vector<Eigen::Vector3d>& polygon, int axis, double origin,
                              int count) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Eigen::Vector3d& p : polygon) {
      low = std::min(low, p[axis]);
      high = std::max(high, p[axis]);
    }
    // One more each way: rounding must not decide.
    const auto cell = [&](double at) {
      return int(std::floor((at - origin) / raster.resolution_m));
    };
    return std::pair(std::max(0, cell(low) - 1), std::min(count - 1, cell(high) + 1));
  };
  const auto cut = [&](const std::vector<Eigen::Vector3d>& polygon, int axis, double origin,
                       int cell) {
    const double from = origin + cell * raster.resolution_m + slack_m;
    const double to = origin + (cell + 1) * raster.resolution_m - slack_m;
    return clip(clip(polygon, axis, -1.0, from), axis, 1.0, to);
  };
  const auto rows = cell_range(footprint.outline_m, 1, raster.origin_y_m, raster.height);
  for (int row = rows.first; row <= rows.second; ++row) {
    const auto strip = cut(footprint.outline_m, 1, raster.origin_y_m, row);
    if (strip.empty()) continue;
    const auto range = cell_range(strip, 0, raster.origin_x_m, raster.width);
    for (int column = range.first; column <= range.second; ++column) {
      const auto part = cut(strip, 0, raster.origin_x_m, column);
      if (part.empty()) continue;
      double low_m = footprint.low_m, high_m = footprint.high_m;
      if (footprint.surface) {
        low_m = high_m = part.front().z();
        for (const Eigen::Vector3d& p : part) {
          low_m = std::min(low_m, p.z());
          high_m = std::max(high_m, p.z());
        }
      }
      const std::size_t i = raster.index(column, row);
      columns->filled[i] |= slices_between(low_m, high_m, band);
      const auto obstacle = static_cast<std::uint8_t>(footprint.obstacle);
      std::uint8_t& held = columns->classes[i];
      held = held == 0 ? obstacle : std::min(held, obstacle);
    }
  }
}

// Calls visit(index) for every cell that can be reached from the seeds through cells that are
// open(index); a cell that is not open is visited, but not left again.
template <class Open, class Visit>
void flood(const MapRaster& raster, std::vector<std::size_t> seeds, bool diagonal, Open open,
           Visit visit) {
  std::vector<bool> reached(raster.index(0, raster.height), false);
  for (const std::size_t i : seeds) reached[i] = true;
  while (!seeds.empty()) {
    const std::size_t i = seeds.back();
    seeds.pop_back();
    visit(i);
    if (!open(i)) continue;
    const int column = static_cast<int>(i % static_cast<std::size_t>(raster.width));
    const int row = static_cast<int>(i / static_cast<std::size_t>(raster.width));
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        if ((!diagonal && dx != 0 && dy != 0) || column + dx < 0 || column + dx >= raster.width ||
            row + dy < 0 || row + dy >= raster.height)
          continue;
        const std::size_t next = raster.index(column + dx, row + dy);
        if (reached[next]) continue;
        reached[next] = true;
        seeds.push_back(next);
      }
  }
}

std::string text_of(const Eigen::Vector2d& p) {
  return "(" + std::to_string(p.x()) + ", " + std::to_string(p.y()) + ")";
}

TruthMap explore(const Columns& columns, const Eigen::Vector2d& start_m, const HeightBand& band) {
  TruthMap map;
  map.raster = columns.raster;
  MapRaster& raster = map.raster;
  raster.probability.assign(columns.filled.size(), kUnknownCell);
  raster.provenance.assign(columns.filled.size(), 0);
  map.classes.assign(columns.filled.size(), 0);
  const std::size_t start =
      raster.index(int(std::floor((start_m.x() - raster.origin_x_m) / raster.resolution_m)),
                   int(std::floor((start_m.y() - raster.origin_y_m) / raster.resolution_m)));
  if (columns.filled[start] != 0)
    throw std::runtime_error("the route starts at " + text_of(start_m) +
                             ", where an obstacle stands; move its first way point");
  std::vector<std::size_t> free_cells;
  flood(
      raster, {start}, false, [&](std::size_t i) { return columns.filled[i] == 0; },
      [&](std::size_t i) {
        if (columns.filled[i] != 0) return;
        raster.probability[i] = kFreeByte;
        free_cells.push_back(i);
        const std::size_t width = static_cast<std::size_t>(raster.width);
        if (i < width || i + width >= raster.probability.size() || i % width == 0 ||
            i % width == width - 1)
          map.closed = false;
      });
  flood(
      raster, free_cells, true,
      [&](std::size_t i) { return sight_passes(columns.filled[i], band); },
      [&](std::size_t i) {
        if (columns.filled[i] == 0) return;
        raster.probability[i] = kOccupiedByte;
        map.classes[i] = columns.classes[i];
      });
  return map;
}

}  // namespace

TruthOptions truth_options_for(const RobotModel& robot) {
  TruthOptions options;
  options.resolution_m = robot.map_resolution_m;
  options.band = {robot.floor_clearance_m, robot.robot_height_m};
  if (robot.has_lidar) options.lidar_height_m = robot.T_base_lidar.translation().z();
  return options;
}

TruthMap make_truth_map(const std::vector<Box>& boxes, const std::vector<TruthTriangle>& triangles,
                        const Eigen::Vector2d& start_m, const TruthOptions& options) {
  std::vector<Footprint> footprints;
  for (const Box& box : boxes) {
    auto footprint = footprint_of(box, options.band);
    if (!footprint) continue;
    if (footprint->obstacle == ObstacleClass::kOther && footprint->high_m < options.lidar_height_m)
      footprint->obstacle = ObstacleClass::kLowBox;
    footprints.push_back(std::move(*footprint));
  }
  for (const TruthTriangle& triangle : triangles)
    if (auto footprint = footprint_of(triangle, options.band))
      footprints.push_back(std::move(*footprint));
  Columns columns = empty_columns(footprints, start_m, options.resolution_m);
  for (const Footprint& footprint : footprints) fill(footprint, options.band, &columns);
  return explore(columns, start_m, options.band);
}

double nearest_obstacle_m(const TruthMap& map, const Eigen::Vector2d& point_m, double up_to_m) {
  const MapRaster& raster = map.raster;
  const double x = point_m.x() - raster.origin_x_m, y = point_m.y() - raster.origin_y_m;
  const auto range = [&](double at, int count) {
    return std::pair(std::max(0, int(std::floor((at - up_to_m) / raster.resolution_m))),
                     std::min(count - 1, int(std::floor((at + up_to_m) / raster.resolution_m))));
  };
  const auto off = [&](double at, int cell) {
    const double low = cell * raster.resolution_m;
    return std::max({low - at, at - low - raster.resolution_m, 0.0});
  };
  const auto columns = range(x, raster.width), rows = range(y, raster.height);
  double nearest = up_to_m;
  for (int row = rows.first; row <= rows.second; ++row)
    for (int column = columns.first; column <= columns.second; ++column)
      if (map.classes[raster.index(column, row)] != 0)
        nearest = std::min(nearest, std::hypot(off(x, column), off(y, row)));
  return nearest;
}

}  // namespace fusion_slam
