// The composed maps of a journal, anew: dense map from the keyframes' images, grids from the
// LiDAR's submaps and the dense map, all where the graph has their nodes.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "fusion_slam/keyframe_image_t.hpp"
#include "libs/camera/camera_model.hpp"
#include "libs/robot/robot_model.hpp"
#include "libs/tiles/tile.hpp"
#include "services/dense_mapper/dense_mapper.hpp"
#include "services/pose_graph/graph_types.hpp"

namespace fusion_slam {

class Recomposer {
 public:
  // Without a camera no dense map is made.
  Recomposer(const RobotModel& robot, const std::optional<CameraModel>& camera);

  void add_submap_tile(const Tile& tile) { submaps_.push_back(tile); }
  void add_image(const keyframe_image_t& image);

  // How the map has to move to be level (hand-held cameras), once all images are in and placed.
  std::optional<LevelWish> place(const GraphNodes& nodes);
  // By channel: GRID_LIDAR, GRID_FUSED, GRID_VISUAL, OCTOMAP, CLOUD.
  std::map<std::string, std::vector<Tile>> compose(const GraphNodes& nodes);

  std::int64_t images_refused() const { return images_refused_; }

 private:
  RobotModel robot_;
  std::optional<DenseMapper> dense_;
  std::vector<Tile> submaps_;
  std::int64_t images_refused_ = 0;
};

}  // namespace fusion_slam
