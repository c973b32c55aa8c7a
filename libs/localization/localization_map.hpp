// A saved map as localisation reads it: the LiDAR's grid with its search pyramids, the views of the
// keyframes with their index. Built once, read-only afterwards.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>

#include "libs/camera/camera_model.hpp"
#include "libs/features/feature.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/grid/tiled_grid.hpp"
#include "libs/localization/config.hpp"
#include "libs/places/place_index.hpp"
#include "libs/robot/robot_model.hpp"
#include "libs/scan_matching/search_pyramid.hpp"

namespace fusion_slam {

struct MapGrid {
  explicit MapGrid(const TiledGrid& grid, double search_cell_m);

  Raster raster;          // the map's own cells
  SearchPyramid pyramid;  // of them
  SearchPyramid coarse;   // of cells about search_cell_m wide, each the fullest of its own
  // The known part, metres, map frame.
  double min_x = 0.0, min_y = 0.0, max_x = 0.0, max_y = 0.0;
};

struct MapView {
  SE3 T_map_base = SE3::Identity();
  FeatureSet features;  // ideal pixels
};

class LocalizationMap {
 public:
  LocalizationMap(const RobotModel& robot, const std::optional<CameraModel>& camera,
                  const LocalizerConfig& config = {});

  void set_grid(const TiledGrid& grid);  // the LiDAR's; nothing known in it: none
  // Ids must grow. Without a camera model: ignored.
  void add_view(std::int64_t keyframe_id, MapView view);

  const RobotModel& robot() const { return robot_; }
  const std::optional<CameraModel>& camera() const { return camera_; }
  const LocalizerConfig& config() const { return config_; }
  const MapGrid* grid() const { return grid_.get(); }
  const std::map<std::int64_t, MapView>& views() const { return views_; }
  const PlaceIndex& index() const { return index_; }

 private:
  RobotModel robot_;
  std::optional<CameraModel> camera_;
  LocalizerConfig config_;
  std::unique_ptr<MapGrid> grid_;
  std::map<std::int64_t, MapView> views_;
  PlaceIndex index_;
};

}  // namespace fusion_slam
