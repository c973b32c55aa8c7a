#include "services/loop_detector/submap_store.hpp"

#include <algorithm>

#include "libs/grid/tiled_grid.hpp"

namespace fusion_slam {

void SubmapStore::add_tile(const Tile& tile) {
  if (tile.encoding == TileEncoding::kEmpty && submaps_.count(tile.key.submap_id) == 0) return;
  Submap& submap = submaps_[tile.key.submap_id];
  const auto known = submap.tiles.find(tile.key);
  if (known != submap.tiles.end() && known->second.revision >= tile.revision) return;
  submap.tiles[tile.key] = tile;
  ++submap.revision;
}

void SubmapStore::add_scan(const LoopScan& scan) {
  submaps_of_[scan.id] = scan.submaps;
  for (const LoopScan::Membership& in : scan.submaps) {
    Submap& submap = submaps_[in.submap_id];
    submap.members.push_back({scan.id, to_se2(in.T_submap_base)});
    submap.last_utime_us = std::max(submap.last_utime_us, scan.utime_us);
  }
}

const std::vector<LoopScan::Membership>& SubmapStore::submaps_of(std::int64_t node_id) const {
  static const std::vector<LoopScan::Membership> kNone;
  const auto it = submaps_of_.find(node_id);
  return it == submaps_of_.end() ? kNone : it->second;
}

const UnpackedSubmap* SubmapStore::unpacked(std::int64_t submap_id) {
  const auto submap = submaps_.find(submap_id);
  if (submap == submaps_.end()) return nullptr;
  Unpacked& entry = unpacked_[submap_id];
  entry.used = ++uses_;
  if (!entry.content || entry.revision != submap->second.revision) {
    entry.revision = submap->second.revision;
    TiledGrid grid(0.05);
    for (const auto& [key, tile] : submap->second.tiles) {
      const auto cells = decode_grid_tile(tile);
      if (!cells) continue;
      if (grid.tiles().empty()) grid = TiledGrid(tile.resolution_m);
      grid.tiles()[{key.x, key.y}] = *cells;
    }
    if (grid.tiles().empty()) {
      unpacked_.erase(submap_id);
      return nullptr;
    }
    const Raster raster = raster_from_tiles(grid);
    entry.content = std::make_unique<UnpackedSubmap>(UnpackedSubmap{raster, SearchPyramid(raster)});
  }
  const UnpackedSubmap* content = entry.content.get();
  while (unpacked_.size() > most_unpacked_)
    unpacked_.erase(std::min_element(
        unpacked_.begin(), unpacked_.end(),
        [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
  return content;
}

}  // namespace fusion_slam
