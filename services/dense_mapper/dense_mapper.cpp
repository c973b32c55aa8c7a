#include "services/dense_mapper/dense_mapper.hpp"

#include <algorithm>
#include <cmath>

#include "services/dense_mapper/supersede.hpp"

namespace fusion_slam {
namespace {

constexpr double kExactSlackM = 1e-6;   // rounding is not motion
constexpr double kSamePlaceM = 0.75;    // an image from there shows the same, but for ...
constexpr double kSamePlaceRad = 0.5;   // ... half of a field of view
constexpr double kSubmapRadiusM = 4.0;  // how far from its anchor a submap matters, for the slack

// How far `to` moves a point at the submap's rim against `from`.
double largest_move_m(const SE3& from, const SE3& to) {
  const SE3 moved = from.inverse() * to;
  return moved.translation().norm() + log_so3(moved.linear()).norm() * kSubmapRadiusM;
}

}  // namespace

DenseMapper::DenseMapper(const CameraModel& camera, const RobotModel& robot,
                         const DenseMapperConfig& config)
    : camera_(camera),
      robot_(robot),
      config_(config),
      base_(robot.map_resolution_m, robot.map_resolution_m / kCloudVoxelsPerCell,
            step_bounds(config)),
      levelled_(robot.planar),
      grid_(robot.map_resolution_m) {}

std::int64_t DenseMapper::submap_of(std::int64_t keyframe_id) const {
  const std::int64_t n = config_.keyframes_per_submap;
  // After a power cut ids go on at the beginning of a thousand: then a submap begins, too.
  const std::int64_t first = std::max(first_id_, (keyframe_id - 1) / 1000 * 1000 + 1);
  return keyframe_id < first_id_ ? 0 : (keyframe_id - first) / n * n + first;
}

void DenseMapper::begin_at(std::int64_t id) {
  first_id_ = id;
  changes_.values = true;
}

SE3 DenseMapper::pose_of(std::int64_t keyframe_id) const {
  const SE3& T = T_map_base_.at(keyframe_id);
  return robot_.planar ? to_se3(to_se2(T)) : T;
}

// Where a submap belongs now: as the graph says, and with what is known of the mounting since.
// Where it is as long as the graph says nothing.
SE3 DenseMapper::placement(std::int64_t id, const DenseSubmap& submap) const {
  if (T_map_base_.count(id) == 0) return submap.T_map_submap;
  return pose_of(id) * mounting_.correction() * submap.T_true_base.inverse();
}

bool DenseMapper::add_keyframe(std::int64_t id, const RgbdFrame& frame) {
  const cv::Size size(camera_.width_px, camera_.height_px);
  if (id < 1 || frame.colour_bgr.size() != size || frame.depth_mm.size() != size ||
      frame.colour_bgr.type() != CV_8UC3 || frame.depth_mm.type() != CV_16UC1)
    return false;
  if (has(id)) return false;
  waiting_.emplace(id, make_depth_cloud(frame, camera_, robot_.map_resolution_m, config_));
  if (waiting_.size() > config_.max_waiting) {
    waiting_.erase(waiting_.begin());
    ++dropped_;
  }
  return true;
}

void DenseMapper::set_pose(std::int64_t id, const SE3& T_map_base, std::int64_t utime_us) {
  // Others hang on their submap's anchor: memory grows with the area, not with time.
  if (!integrated_.contains(id) || submaps_.count(id) != 0) T_map_base_[id] = T_map_base;
  graph_us_ = std::max(graph_us_, utime_us);
  if (wish_ && id == wish_->anchor_id) check_wish();
}

void DenseMapper::integrate_ready() {
  for (auto it = waiting_.begin(); it != waiting_.end();) {
    if (!ready(it->first)) {
      ++it;
      continue;
    }
    const std::int64_t submap_id = submap_of(it->first);
    integrate(it->first, submap_id, it->second);
    integrated_.insert(it->first);
    if (it->first != submap_id) T_map_base_.erase(it->first);
    it = waiting_.erase(it);
  }
}

bool DenseMapper::repeats_a_place(std::int64_t id) const {
  if (submap_of(id) != id || submaps_.count(id) != 0 || T_map_base_.count(id) == 0) return false;
  const SE3 T_map_base = pose_of(id);
  return std::any_of(submaps_.begin(), submaps_.end(), [&](const auto& entry) {
    const DenseSubmap& submap = entry.second;
    if (!submap.closed || submap.packed.empty()) return false;
    const SE3 moved = submap.T_map_submap.inverse() * T_map_base;
    return moved.translation().norm() < kSamePlaceM &&
           log_so3(moved.linear()).norm() < kSamePlaceRad;
  });
}

bool DenseMapper::belongs_to_left_out(std::int64_t id) const {
  const std::int64_t submap_id = submap_of(id);
  return integrated_.contains(submap_id) && submaps_.count(submap_id) == 0;
}

void DenseMapper::leave_out(std::int64_t id) {
  const std::int64_t submap_id = submap_of(id);
  std::set<std::int64_t> ids{id};
  for (auto it = waiting_.lower_bound(id);
       it != waiting_.end() && submap_of(it->first) == submap_id; it = waiting_.erase(it))
    ids.insert(it->first);
  for (const std::int64_t one : ids) {
    if (!integrated_.insert(one)) continue;
    T_map_base_.erase(one);
    if (keeps_changes_) changes_.left_out.insert(one);
  }
}

DenseSubmap& DenseMapper::submap_for(std::int64_t submap_id) {
  auto it = submaps_.find(submap_id);
  if (it != submaps_.end()) return it->second;
  it =
      submaps_.emplace(submap_id, DenseSubmap(robot_.map_resolution_m / kCloudVoxelsPerCell)).first;
  it->second.T_true_base = mounting_.correction();
  it->second.T_map_submap = placement(submap_id, it->second);
  placed_submap(submap_id);
  return it->second;
}

void DenseMapper::integrate(std::int64_t keyframe_id, std::int64_t submap_id,
                            const DepthCloud& cloud) {
  const double resolution_m = robot_.map_resolution_m;
  const bool repeated = to_repeat_.erase(keyframe_id) != 0;
  if (robot_.planar && !repeated) mounting_.add(cloud, robot_.T_base_camera);
  DenseSubmap& submap = submap_for(submap_id);
  const SE3 T_submap_camera = repeated ? open_keyframes_.at(keyframe_id).T_submap_camera
                                       : pose_of(submap_id).inverse() * pose_of(keyframe_id) *
                                             submap.T_true_base * robot_.T_base_camera;
  open_keyframes_[keyframe_id] = {submap_id, T_submap_camera};
  if (keeps_changes_ && !repeated) changes_.keyframes[keyframe_id] = {submap_id, T_submap_camera};
  ++fresh_keyframes_;
  newest_us_ = std::max(newest_us_, cloud.utime_us);
  if (submap.closed || submap_id < base_upto_) {
    integrate_late(cloud, T_submap_camera, submap_id, &submap);
    return changed_submap(submap_id);
  }
  const std::set<BlockIndex> blocks = integrate_cloud(cloud, T_submap_camera, camera_, resolution_m,
                                                      config_, !robot_.planar, &submap);
  std::set<CubeIndex> touched;
  const double edge_m = kBlockVoxels * resolution_m;
  for (const BlockIndex& block : blocks) {
    const Eigen::Vector3d low_m = Eigen::Vector3d(block.x, block.y, block.z) * edge_m;
    insert_touched(low_m, low_m + Eigen::Vector3d::Constant(edge_m), submap.T_map_submap,
                   kOctomapTileVoxels * resolution_m, &touched);
  }
  mark(touched);
}

// Newer submaps lie above this one already.
void DenseMapper::integrate_late(const DepthCloud& cloud, const SE3& T_submap_camera,
                                 std::int64_t submap_id, DenseSubmap* submap) {
  if (submap->closed) open_submap(submap);
  integrate_cloud(cloud, T_submap_camera, camera_, robot_.map_resolution_m, config_, !robot_.planar,
                  submap);
  close_submap(robot_.map_resolution_m, submap);
  mark_all(submap_id, *submap);
}

bool DenseMapper::needs_placing(std::int64_t id, const DenseSubmap& submap, double slack_m) const {
  return largest_move_m(submap.T_map_submap, placement(id, submap)) > slack_m;
}

bool DenseMapper::anything_moved(double slack_m) const {
  return std::any_of(submaps_.begin(), submaps_.end(), [&](const auto& entry) {
    return needs_placing(entry.first, entry.second, slack_m);
  });
}

bool DenseMapper::due() const {
  if (fresh_keyframes_ > 0 || grid_is_late_) return true;
  if (!follows_moves_) return false;
  if (!dirty_base_.empty()) return true;
  if (graph_us_ < placed_us_ + config_.moved_period_us) return false;
  return anything_moved(config_.slack_voxels * robot_.map_resolution_m);
}

DenseTiles DenseMapper::update(bool exact) {
  DenseTiles tiles = update_grid(exact);
  DenseTiles maps = update_maps();
  tiles.octomap = std::move(maps.octomap);
  tiles.cloud = std::move(maps.cloud);
  return tiles;
}

DenseTiles DenseMapper::update_grid(bool exact) {
  finishing_ = exact;
  maps_due_ |= exact || grid_is_late_;
  if (exact ||
      (follows_moves_ && !part_followed_ && graph_us_ >= placed_us_ + config_.moved_period_us))
    maps_due_ |=
        place_submaps(exact ? kExactSlackM : config_.slack_voxels * robot_.map_resolution_m);
  follow_in_base(exact || grid_is_late_);
  fresh_keyframes_ = 0;
  grid_is_late_ = false;
  DenseTiles tiles;
  if (level()) publish_grid(&tiles.grid);
  return tiles;
}

DenseTiles DenseMapper::update_maps() {
  if (!dirty_points_.empty()) base_.rebuild_points(dirty_points_, submaps_, base_upto_);
  dirty_points_.clear();
  maps_due_ |= close_full_submaps();
  DenseTiles tiles;
  if (!maps_due_) return tiles;
  maps_due_ = false;
  const Composed composed = compose(dirty_cubes_, SliceRange{});
  publish_octomap(composed, &tiles.octomap);
  publish_clouds(composed, &tiles.cloud);
  dirty_cubes_.clear();
  return tiles;
}

bool DenseMapper::place_submaps(double slack_m) {
  placed_us_ = graph_us_;
  bool moved = false;
  for (auto& [id, submap] : submaps_) {
    if (!needs_placing(id, submap, slack_m)) continue;
    mark_all(id, submap);  // what it leaves
    submap.T_map_submap = placement(id, submap);
    placed_submap(id);
    if (submap.closed) {
      const auto touched = touched_cubes(submap, robot_.map_resolution_m);
      submap.touches.assign(touched.begin(), touched.end());
    }
    mark_all(id, submap);  // where it goes
    moved = true;
  }
  return moved;
}

// The whole map takes seconds, and who waits for a raster must not wait for that. What is left over
// is the old map, whole and published: nobody sees a cube that is neither old nor new.
void DenseMapper::follow_in_base(bool all) {
  std::set<CubeIndex> cubes;
  if (all) cubes.swap(dirty_base_);
  while (follows_moves_ && !dirty_base_.empty() && cubes.size() < cubes_a_step_)
    cubes.insert(dirty_base_.extract(dirty_base_.begin()));
  part_followed_ = !dirty_base_.empty();
  if (cubes.empty()) return;
  base_.rebuild_cells(cubes, submaps_, base_upto_);
  cubes_followed_ += cubes.size();
  mark(cubes);
  dirty_points_.merge(cubes);
  maps_due_ = true;
}

void DenseMapper::mark_all(std::int64_t id, const DenseSubmap& submap) {
  if (submap.closed) dirty_base_.insert(submap.touches.begin(), submap.touches.end());
  if (!submap.closed || id >= base_upto_) mark(touched_cubes(submap, robot_.map_resolution_m));
}

void DenseMapper::mark(const std::set<CubeIndex>& cubes) {
  dirty_cubes_.insert(cubes.begin(), cubes.end());
  for (const CubeIndex& cube : cubes) dirty_columns_.insert({cube.x, cube.y});
}

// A submap is closed when all its keyframes are in, or none can be expected any more.
bool DenseMapper::close_full_submaps() {
  if (submaps_.empty()) return false;
  const std::int64_t given_up =
      submaps_.rbegin()->first - config_.open_submaps * config_.keyframes_per_submap;
  bool any = false;
  for (auto& [id, submap] : submaps_) {
    if (submap.closed ||
        !(finishing_ || submap.n_keyframes >= config_.keyframes_per_submap || id <= given_up))
      continue;
    close_submap(robot_.map_resolution_m, &submap);
    changed_submap(id);
    dirty_cubes_.insert(submap.touches.begin(), submap.touches.end());  // its points are new
    any = true;
  }
  if (any) extend_base();
  return any;
}

void DenseMapper::extend_base() {
  for (auto it = submaps_.lower_bound(base_upto_); it != submaps_.end(); ++it) {
    if (!it->second.closed) return;
    base_.extend(it->second);  // also where all is to be composed again: with this one, then
    base_upto_ = it->first + 1;
    std::set<std::int64_t> counted;
    const std::int64_t old =
        count_newer(it->first, 2 * config_.submaps_that_count, &submaps_, &counted);
    for (const std::int64_t id : counted) placed_submap(id);
    if (old != 0) supersede(old);
    for (int i = 0; i < config_.more_superseded && holds_too_much(); ++i) {
      const std::int64_t ripe = ripest(2 * config_.submaps_that_count, submaps_);
      if (ripe == 0) break;
      supersede(ripe);
    }
  }
}

bool DenseMapper::holds_too_much() const {
  return static_cast<double>(submap_bytes()) >
         config_.submaps_over_map * static_cast<double>(map_bytes());
}

void DenseMapper::supersede(std::int64_t id) {
  const bool empty = drop_superseded(id, config_.submaps_that_count, robot_.map_resolution_m,
                                     robot_.map_resolution_m / kCloudVoxelsPerCell, &submaps_);
  changed_submap(id);
  if (empty && robot_.planar) forget_submap(id);
}

// Nothing is left of it; a hand-held camera's still says what is level.
void DenseMapper::forget_submap(std::int64_t id) {
  for (auto it = open_keyframes_.begin(); it != open_keyframes_.end();) {
    if (it->second.submap_id != id) {
      ++it;
      continue;
    }
    integrated_.insert(it->first);
    to_repeat_.erase(it->first);
    it = open_keyframes_.erase(it);
  }
  submaps_.erase(id);
  T_map_base_.erase(id);
}

std::size_t DenseMapper::submap_bytes() const {
  std::size_t sum = 0;
  for (const auto& [id, submap] : submaps_) sum += size_bytes(submap);
  return sum;
}

}  // namespace fusion_slam
