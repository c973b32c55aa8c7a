// When the dense mapper asks the pose graph to level the map, and how it knows that it has been.
#include "services/dense_mapper/dense_mapper.hpp"

namespace fusion_slam {

// Of the base, by the graph, or where it was placed when the graph says nothing of it.
SE3 DenseMapper::pose_or_place(std::int64_t id, const DenseSubmap& submap) const {
  const auto it = T_map_base_.find(id);
  return it == T_map_base_.end() ? submap.T_map_submap : it->second;
}

// Up and floor are estimated whenever the keyframes have doubled, and for the final map: at most
// once for each number of keyframes, so that asking and being moved can't go on for ever.
std::optional<LevelWish> DenseMapper::wish_level(bool exact) {
  if (robot_.planar || submaps_.empty()) return std::nullopt;
  const std::size_t n = integrated_.size();
  const bool doubled = level_keyframes_ == 0 || n >= 2 * level_keyframes_;
  if (!doubled && !(exact && n > level_keyframes_)) return std::nullopt;

  std::vector<SurfacePoint> surfaces;
  std::vector<Eigen::Vector3d> cameras_m;
  Eigen::Vector3d image_up = Eigen::Vector3d::Zero();
  for (const auto& [id, submap] : submaps_) {
    const SE3 T = pose_or_place(id, submap);
    for (const SurfacePoint& s : submap.surfaces)
      surfaces.push_back({(T * s.p_m.cast<double>()).cast<float>(),
                          (T.linear() * s.normal.cast<double>()).cast<float>()});
    for (const Eigen::Vector3d& p : submap.camera_positions_m) cameras_m.push_back(T * p);
    image_up += T.linear() * submap.image_up_sum;
  }
  const auto level = estimate_level(surfaces, image_up, cameras_m);
  if (!level) return std::nullopt;
  level_keyframes_ = n;
  changes_.values = true;
  floor_seen_ = level->floor_seen;
  if (!worth_levelling(level->T_level_map, robot_.map_resolution_m)) {
    found_level();
    return std::nullopt;
  }
  const std::int64_t anchor_id = submaps_.begin()->first;
  const SE3 T_level_anchor = level->T_level_map * pose_or_place(anchor_id, submaps_.at(anchor_id));
  wish_ = LevelWish{anchor_id, T_level_anchor, level->floor_seen, newest_us_};
  return wish_;
}

// The graph has said where the anchor is now: as wished?
void DenseMapper::check_wish() {
  if (!wish_) return;
  const SE3 T_wished_map = levelling(T_map_base_.at(wish_->anchor_id), wish_->T_level_anchor);
  if (!worth_levelling(T_wished_map, robot_.map_resolution_m)) found_level();
}

void DenseMapper::found_level() {
  if (!levelled_ || wish_) grid_is_late_ = true;
  wish_.reset();
  levelled_ = true;
  changes_.values = true;
}

}  // namespace fusion_slam
