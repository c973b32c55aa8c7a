// What the dense mapper writes down for a restart, and how it goes on from there.
#include "services/dense_mapper/dense_mapper.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kRecordBytes = 1 << 20;

}  // namespace

bool DenseMapper::ready(std::int64_t id) const {
  if (to_repeat_.count(id) != 0) return true;
  return T_map_base_.count(id) != 0 && T_map_base_.count(submap_of(id)) != 0;
}

std::set<std::int64_t> DenseMapper::needed_images() const {
  std::set<std::int64_t> ids;
  for (const auto& [id, keyframe] : open_keyframes_) ids.insert(id);
  for (const auto& [id, cloud] : waiting_) ids.insert(id);
  return ids;
}

void DenseMapper::changed_submap(std::int64_t id) {
  // Those whose images are still to be mapped again are late then, but not lost.
  for (auto it = open_keyframes_.begin(); it != open_keyframes_.end();)
    it = it->second.submap_id == id && to_repeat_.count(it->first) == 0 ? open_keyframes_.erase(it)
                                                                        : std::next(it);
  if (keeps_changes_) changes_.whole.insert(id);
}

void DenseMapper::placed_submap(std::int64_t id) {
  if (keeps_changes_) changes_.placed.insert(id);
}

SavedValues DenseMapper::saved_values() const {
  SavedValues values;
  values.resolution_m = robot_.map_resolution_m;
  values.first_id = first_id_;
  values.base_upto = base_upto_;
  values.newest_us = newest_us_;
  values.placed_us = placed_us_;
  values.level_keyframes = static_cast<std::int64_t>(level_keyframes_);
  values.levelled = levelled_;
  values.floor_seen = floor_seen_;
  values.wish = wish_;
  values.mounting = mounting_;
  return values;
}

void DenseMapper::note_dirty_base(SavedMapWriter* out) {
  if (!dirty_base_.empty() || dirty_base_noted_) out->dirty_base(dirty_base_);
  dirty_base_noted_ = !dirty_base_.empty();
}

SavedBytes DenseMapper::take_changes() {
  const Changes changes = std::exchange(changes_, {});
  const std::set<CubeIndex> cubes = base_.take_changed_cubes();
  const std::set<TileKey> clouds = base_.take_changed_clouds();
  if (!changes.values && changes.keyframes.empty() && changes.left_out.empty() &&
      changes.whole.empty() && changes.placed.empty() && cubes.empty() && clouds.empty())
    return {};
  SavedMapWriter out;
  out.values(saved_values());
  for (const auto& [id, keyframe] : changes.keyframes) out.keyframe(id, keyframe);
  for (const std::int64_t id : changes.left_out) out.integrated(id, id);
  for (const std::int64_t id : changes.whole) {
    const auto it = submaps_.find(id);
    if (it == submaps_.end())
      out.gone_submap(id);
    else
      out.whole_submap(id, it->second);
  }
  for (const std::int64_t id : changes.placed) {
    const auto it = submaps_.find(id);
    if (it != submaps_.end() && changes.whole.count(id) == 0) out.placed_submap(id, it->second);
  }
  note_dirty_base(&out);
  const PackedBytes nothing;
  for (const CubeIndex& index : cubes) {
    const auto it = base_.cubes().find(index);
    out.base_cube(index, it == base_.cubes().end() ? nothing : it->second);
  }
  for (const TileKey& key : clouds) {
    const auto it = base_.clouds().find(key);
    out.base_cloud(key, it == base_.clouds().end() ? nothing : it->second);
  }
  return out.take();
}

void DenseMapper::write_all(const std::function<void(const SavedBytes&)>& emit) {
  changes_ = {};
  base_.take_changed_cubes();
  base_.take_changed_clouds();
  SavedMapWriter out;
  const auto emit_full = [&](std::size_t size_bytes) {
    if (out.size_bytes() >= size_bytes) emit(out.take());
  };
  out.values(saved_values());
  note_dirty_base(&out);
  for (const auto& [first, last] : integrated_.ranges()) {
    std::int64_t from = first;  // those of open submaps apart
    for (auto it = open_keyframes_.lower_bound(first);
         it != open_keyframes_.end() && it->first <= last; ++it) {
      if (from < it->first) out.integrated(from, it->first - 1);
      from = it->first + 1;
    }
    if (from <= last) out.integrated(from, last);
  }
  for (const auto& [id, submap] : submaps_) {
    if (submap.closed)
      out.whole_submap(id, submap);
    else
      out.placed_submap(id, submap);
    emit_full(kRecordBytes);
  }
  for (const auto& [id, keyframe] : open_keyframes_) out.keyframe(id, keyframe);
  for (const auto& [index, bytes] : base_.cubes()) {
    out.base_cube(index, bytes);
    emit_full(kRecordBytes);
  }
  for (const auto& [key, bytes] : base_.clouds()) {
    out.base_cloud(key, bytes);
    emit_full(kRecordBytes);
  }
  emit_full(1);
}

bool DenseMapper::restore(SavedMap map) {
  const SavedValues& values = map.values;
  if (values.resolution_m != robot_.map_resolution_m) return false;
  first_id_ = values.first_id;
  base_upto_ = values.base_upto;
  newest_us_ = values.newest_us;
  placed_us_ = values.placed_us;
  level_keyframes_ = static_cast<std::size_t>(values.level_keyframes);
  levelled_ = values.levelled;
  floor_seen_ = values.floor_seen;
  wish_ = values.wish;
  mounting_ = values.mounting;
  integrated_ = std::move(map.integrated);
  open_keyframes_ = std::move(map.open_keyframes);
  for (const auto& [id, keyframe] : open_keyframes_) to_repeat_.insert(id);
  submaps_ = std::move(map.submaps);
  for (auto& [id, submap] : submaps_) {
    if (!submap.closed) continue;
    const auto touched = touched_cubes(submap, robot_.map_resolution_m);
    submap.touches.assign(touched.begin(), touched.end());
  }
  base_.restore(std::move(map.base_cubes), std::move(map.base_clouds));
  dirty_base_ = std::move(map.dirty_base);
  dirty_base_noted_ = part_followed_ = !dirty_base_.empty();
  std::set<CubeIndex> cubes;
  for (const auto& [index, bytes] : base_.cubes()) cubes.insert(index);
  for (const auto& [key, bytes] : base_.clouds())
    cubes.insert({key.x >> 1, key.y >> 1, key.z >> 1});
  mark(cubes);
  maps_due_ = true;
  ++fresh_keyframes_;
  return true;
}

}  // namespace fusion_slam
