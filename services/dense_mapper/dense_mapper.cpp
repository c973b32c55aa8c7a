#include "services/dense_mapper/dense_mapper.hpp"

#include <algorithm>
#include <cmath>

#include "libs/octree/octomap_tile.hpp"
#include "services/dense_mapper/raster.hpp"

namespace fusion_slam {
namespace {

constexpr double kCloudVoxelsPerCell = 2.0;  // the cloud is twice as fine as the OctoMap
constexpr double kExactSlackM = 1e-6;        // rounding is not motion
constexpr double kSubmapRadiusM = 4.0;  // how far from its anchor a submap matters, for the slack

// How far `to` moves a point at the submap's rim against `from`.
double largest_move_m(const SE3& from, const SE3& to) {
  const SE3 moved = from.inverse() * to;
  return moved.translation().norm() + log_so3(moved.linear()).norm() * kSubmapRadiusM;
}

}  // namespace

DenseMapper::DenseMapper(const CameraModel& camera, const RobotModel& robot,
                         const DenseMapperConfig& config)
    : camera_(camera), robot_(robot), config_(config), levelled_(robot.planar) {}

std::int64_t DenseMapper::submap_of(std::int64_t keyframe_id) const {
  return (keyframe_id - 1) / config_.keyframes_per_submap * config_.keyframes_per_submap + 1;
}

bool DenseMapper::add_keyframe(std::int64_t id, const RgbdFrame& frame) {
  const cv::Size size(camera_.width_px, camera_.height_px);
  if (id < 1 || frame.colour_bgr.size() != size || frame.depth_mm.size() != size ||
      frame.colour_bgr.type() != CV_8UC3 || frame.depth_mm.type() != CV_16UC1)
    return false;
  if (waiting_.count(id) != 0 || integrated_.count(id) != 0) return false;
  waiting_.emplace(id, make_depth_cloud(frame, camera_, robot_.map_resolution_m, config_));
  if (waiting_.size() > config_.max_waiting) {
    waiting_.erase(waiting_.begin());
    ++dropped_;
  }
  return true;
}

void DenseMapper::set_pose(std::int64_t id, const SE3& T_map_base, std::int64_t utime_us) {
  T_map_base_[id] = T_map_base;
  graph_us_ = std::max(graph_us_, utime_us);
  if (wish_ && id == wish_->anchor_id) check_wish();
}

void DenseMapper::integrate_ready() {
  for (auto it = waiting_.begin(); it != waiting_.end();) {
    const std::int64_t submap_id = submap_of(it->first);
    if (T_map_base_.count(it->first) == 0 || T_map_base_.count(submap_id) == 0) {
      ++it;
      continue;
    }
    integrate(it->first, submap_id, it->second);
    integrated_.insert(it->first);
    it = waiting_.erase(it);
  }
}

void DenseMapper::integrate(std::int64_t keyframe_id, std::int64_t submap_id,
                            const DepthCloud& cloud) {
  const double resolution_m = robot_.map_resolution_m;
  const SE3& T_map_submap = T_map_base_.at(submap_id);
  auto it = submaps_.find(submap_id);
  if (it == submaps_.end()) {
    it = submaps_.emplace(submap_id, DenseSubmap(resolution_m / kCloudVoxelsPerCell)).first;
    it->second.T_map_submap = T_map_submap;
  }
  const SE3 T_submap_camera =
      T_map_submap.inverse() * T_map_base_.at(keyframe_id) * robot_.T_base_camera;
  const std::set<BlockIndex> blocks =
      integrate_cloud(cloud, T_submap_camera, camera_, resolution_m, config_, &it->second);
  changes_.blocks[submap_id].insert(blocks.begin(), blocks.end());
  ++changes_.keyframes;
  newest_us_ = std::max(newest_us_, cloud.utime_us);
}

bool DenseMapper::needs_placing(std::int64_t id, const DenseSubmap& submap, double slack_m) const {
  return largest_move_m(submap.T_map_submap, T_map_base_.at(id)) > slack_m;
}

bool DenseMapper::due() const {
  if (changes_.keyframes >= config_.keyframes_per_publication || grid_is_late_) return true;
  if (graph_us_ < published_us_ + config_.moved_period_us) return false;
  const double slack_m = config_.slack_voxels * robot_.map_resolution_m;
  return std::any_of(submaps_.begin(), submaps_.end(), [&](const auto& entry) {
    return needs_placing(entry.first, entry.second, slack_m);
  });
}

DenseTiles DenseMapper::update(bool exact) {
  place_submaps(exact);
  for (const auto& [id, blocks] : changes_.blocks)
    for (const BlockIndex& block : blocks) mark(submaps_.at(id), block);
  changes_ = Changes{};
  published_us_ = graph_us_;
  grid_is_late_ = false;

  DenseTiles tiles;
  compose_octomap(&tiles.octomap);
  compose_clouds(&tiles.cloud);
  if (level()) compose_grid(&tiles.grid);
  return tiles;
}

void DenseMapper::place_submaps(bool exact) {
  const double slack_m = exact ? kExactSlackM : config_.slack_voxels * robot_.map_resolution_m;
  for (auto& [id, submap] : submaps_) {
    if (!needs_placing(id, submap, slack_m)) continue;
    mark_all(submap);  // what it leaves
    submap.T_map_submap = T_map_base_.at(id);
    mark_all(submap);  // where it goes
  }
}

void DenseMapper::mark_all(const DenseSubmap& submap) {
  for (const auto& [index, block] : submap.voxels.blocks()) mark(submap, index);
}

// Everything a block of a submap touches has to be composed again.
void DenseMapper::mark(const DenseSubmap& submap, const BlockIndex& block) {
  const double resolution_m = robot_.map_resolution_m;
  const double cloud_resolution_m = resolution_m / kCloudVoxelsPerCell;
  const SE3& T = submap.T_map_submap;
  const auto insert = [](const TileRange& range, std::set<TileKey>* keys) {
    for (int x = range.low.x(); x <= range.high.x(); ++x)
      for (int y = range.low.y(); y <= range.high.y(); ++y)
        for (int z = range.low.z(); z <= range.high.z(); ++z) keys->insert({0, x, y, z});
  };
  insert(tiles_of_block(block, resolution_m, T, kOctomapTileVoxels * resolution_m),
         &dirty_octomap_);
  insert(tiles_of_block(block, resolution_m, T, kCloudTileVoxels * cloud_resolution_m),
         &dirty_cloud_);
  const TileRange grid = tiles_of_block(block, resolution_m, T, kTileCells * resolution_m);
  for (int x = grid.low.x(); x <= grid.high.x(); ++x)
    for (int y = grid.low.y(); y <= grid.high.y(); ++y) dirty_grid_.insert({x, y});
}

void DenseMapper::compose_octomap(std::vector<Tile>* out) {
  LatticeBox box;
  box.resolution_m = robot_.map_resolution_m;
  box.size.setConstant(kOctomapTileVoxels);
  const double edge_m = kOctomapTileVoxels * box.resolution_m;
  for (const TileKey& key : dirty_octomap_) {
    box.low_m = Eigen::Vector3d(key.x, key.y, key.z) * edge_m;
    const std::vector<std::int8_t> voxels = compose_voxels(submaps_, box, config_);
    VoxelCells cells;
    std::copy(voxels.begin(), voxels.end(), cells.begin());
    auto tile =
        octomap_tiles_.offer(encode_octomap_tile(key, cells, box.resolution_m, 0, newest_us_));
    if (tile) out->push_back(std::move(*tile));
  }
  dirty_octomap_.clear();
}

void DenseMapper::compose_clouds(std::vector<Tile>* out) {
  const double resolution_m = robot_.map_resolution_m / kCloudVoxelsPerCell;
  const auto points = compose_cloud(submaps_, dirty_cloud_, resolution_m);
  for (const TileKey& key : dirty_cloud_) {
    const auto it = points.find(key);
    auto tile = cloud_tiles_.offer(
        encode_cloud_tile(key, it == points.end() ? std::vector<ColouredPoint>{} : it->second,
                          resolution_m, 0, newest_us_));
    if (tile) out->push_back(std::move(*tile));
  }
  dirty_cloud_.clear();
}

void DenseMapper::compose_grid(std::vector<Tile>* out) {
  LatticeBox box;
  box.resolution_m = robot_.map_resolution_m;
  // A submap of a tilted camera has tilted voxels: the floor's reach up to a voxel's diagonal above
  // it.
  const double clearance_m = robot_.planar
                                 ? robot_.floor_clearance_m
                                 : std::max(robot_.floor_clearance_m, 2.0 * box.resolution_m);
  const double band_m = std::max(robot_.robot_height_m - clearance_m, box.resolution_m);
  box.size = {kTileCells, kTileCells, static_cast<int>(std::lround(band_m / box.resolution_m))};
  const double edge_m = kTileCells * box.resolution_m;
  for (const TileIndex& index : dirty_grid_) {
    box.low_m = Eigen::Vector3d(index.first * edge_m, index.second * edge_m, clearance_m);
    const TileCells cells = raster_tile(compose_voxels(submaps_, box, config_));
    Tile tile =
        encode_grid_tile({0, index.first, index.second, 0}, cells, box.resolution_m, 0, newest_us_);
    const bool known = std::any_of(cells.begin(), cells.end(),
                                   [](std::uint8_t cell) { return cell != kUnknownCell; });
    if (!known) {
      tile.encoding = TileEncoding::kEmpty;
      tile.data.clear();
    }
    if (auto fresh = grid_tiles_.offer(std::move(tile))) out->push_back(std::move(*fresh));
  }
  dirty_grid_.clear();
}

}  // namespace fusion_slam
