#include "libs/localization/localization_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace fusion_slam {
namespace {

// Each coarse cell is the fullest of the cells in it; unknown (0) only where all are.
Raster coarsened(const Raster& fine, int factor) {
  Raster coarse(fine.resolution_m() * factor, kUnknownCell);
  const auto down = [factor](int cell) {
    return static_cast<int>(std::floor(static_cast<double>(cell) / factor));
  };
  coarse.include({down(fine.min_x()), down(fine.min_y())},
                 {down(fine.min_x() + fine.width() - 1), down(fine.min_y() + fine.height() - 1)});
  for (int y = fine.min_y(); y < fine.min_y() + fine.height(); ++y)
    for (int x = fine.min_x(); x < fine.min_x() + fine.width(); ++x) {
      std::uint8_t& cell = coarse.cell(down(x), down(y));
      cell = std::max(cell, fine.at(x, y));
    }
  return coarse;
}

int factor_for(double resolution_m, double search_cell_m) {
  return std::max(1, static_cast<int>(std::lround(search_cell_m / resolution_m)));
}

// The newest keyframes of a map are places like all others.
AppearanceConfig all_at_once(AppearanceConfig config) {
  config.not_before_keyframes = 0;
  config.not_before_us = 0;
  return config;
}

}  // namespace

MapGrid::MapGrid(const TiledGrid& grid, double search_cell_m)
    : raster(raster_from_tiles(grid)),
      pyramid(raster),
      coarse(coarsened(raster, factor_for(grid.resolution_m(), search_cell_m))) {
  int x0 = std::numeric_limits<int>::max(), y0 = x0;
  int x1 = std::numeric_limits<int>::min(), y1 = x1;
  for (int y = raster.min_y(); y < raster.min_y() + raster.height(); ++y)
    for (int x = raster.min_x(); x < raster.min_x() + raster.width(); ++x) {
      if (raster.at(x, y) == kUnknownCell) continue;
      x0 = std::min(x0, x), y0 = std::min(y0, y);
      x1 = std::max(x1, x), y1 = std::max(y1, y);
    }
  if (x1 < x0) return;
  const double cell = raster.resolution_m();
  min_x = x0 * cell, min_y = y0 * cell, max_x = (x1 + 1) * cell, max_y = (y1 + 1) * cell;
}

LocalizationMap::LocalizationMap(const RobotModel& robot, const std::optional<CameraModel>& camera,
                                 const LocalizerConfig& config)
    : robot_(robot), camera_(camera), config_(config), index_(all_at_once(config.appearance)) {}

void LocalizationMap::set_grid(const TiledGrid& grid) {
  grid_.reset();
  if (grid.tiles().empty()) return;
  auto built = std::make_unique<MapGrid>(grid, config_.lidar.cell_m);
  if (built->max_x > built->min_x) grid_ = std::move(built);
}

void LocalizationMap::add_view(std::int64_t keyframe_id, MapView view) {
  if (!camera_) return;
  index_.add(keyframe_id, keyframe_id, view.features);
  views_[keyframe_id] = std::move(view);
}

}  // namespace fusion_slam
