#include "logplayer/map_merge/recompose.hpp"

#include <algorithm>

#include "libs/camera_messages/images.hpp"
#include "services/fuser/fuser.hpp"

namespace fusion_slam {

Recomposer::Recomposer(const RobotModel& robot, const std::optional<CameraModel>& camera)
    : robot_(robot) {
  if (camera && robot.has_camera) dense_.emplace(*camera, robot, DenseMapperConfig{});
}

void Recomposer::add_image(const keyframe_image_t& image) {
  std::string why;
  const auto frame = dense_ ? from_message(image.images, &why) : std::nullopt;
  if (!frame || !dense_->add_keyframe(image.id, *frame)) ++images_refused_;
}

std::optional<LevelWish> Recomposer::place(const GraphNodes& nodes) {
  if (!dense_) return std::nullopt;
  for (const auto& [id, node] : nodes)
    if (id.kind == NodeKind::kKeyframe) dense_->set_pose(id.id, node.T_map_base, node.utime_us);
  dense_->integrate_ready();
  return dense_->wish_level(true);
}

std::map<std::string, std::vector<Tile>> Recomposer::compose(const GraphNodes& nodes) {
  std::map<std::string, std::vector<Tile>> tiles;
  Fuser fuser(robot_.map_resolution_m, FuserConfig{});
  for (const Tile& tile : submaps_) fuser.add_submap_tile(tile);
  for (const auto& [id, node] : nodes)
    if (id.kind == NodeKind::kLidar) fuser.set_anchor(id.id, node.T_map_base, node.utime_us);
  if (dense_) {
    place(nodes);
    DenseTiles dense = dense_->update(true);
    for (const Tile& tile : dense.grid) fuser.add_visual_tile(tile);
    tiles["GRID_VISUAL"] = std::move(dense.grid);
    tiles["OCTOMAP"] = std::move(dense.octomap);
    tiles["CLOUD"] = std::move(dense.cloud);
  }
  FuserOutput grids = fuser.update(true);
  tiles["GRID_LIDAR"] = std::move(grids.lidar);
  tiles["GRID_FUSED"] = std::move(grids.fused);
  return tiles;
}

}  // namespace fusion_slam
