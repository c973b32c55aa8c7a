// octomap.bt and octomap.ot, as octovis and octomap_server read them.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libs/octree/octomap_tile.hpp"
#include "libs/tiles/tile.hpp"

namespace fusion_slam {

// The tiles of the global map (submap 0) as a pruned binary octree. Nothing, with the reason in
// `why`, when there is no voxel. Tiles of another resolution than the first's, and voxels beyond
// OctoMap's key range (32768 voxels from the origin), are left out; a tile that can't be decoded,
// too.
std::optional<std::string> octomap_bt_bytes(const std::map<TileKey, Tile>& tiles, std::string* why);

// The same with the log-odds of each voxel.
std::optional<std::string> octomap_ot_bytes(const std::map<TileKey, Tile>& tiles, std::string* why);

}  // namespace fusion_slam
