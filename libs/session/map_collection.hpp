// The newest tile of each key of the global maps.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libs/cloud/cloud_tile.hpp"
#include "libs/maps/map_raster.hpp"
#include "libs/tiles/tile.hpp"

namespace fusion_slam {

class MapCollection {
 public:
  // GRID_FUSED, GRID_LIDAR, GRID_VISUAL, OCTOMAP, CLOUD; tiles of other channels and of submaps are
  // none of its business.
  void add(const std::string& channel, const Tile& tile);

  // The best grid there is: fused, else LiDAR's, else camera's. `source` is its channel. Nothing,
  // with a reason, when there is none.
  std::optional<MapRaster> grid(std::string* source, std::string* why) const;
  // GRID_FUSED, GRID_LIDAR or GRID_VISUAL as it is. Nothing, with a reason, when no cell is known.
  std::optional<MapRaster> grid_of(const std::string& channel, std::string* why) const;
  std::vector<ColouredPoint> cloud() const;  // tile by tile in key order
  const std::map<TileKey, Tile>& octomap() const { return octomap_; }
  std::size_t damaged_tiles() const { return damaged_; }

 private:
  using Channel = std::map<TileKey, Tile>;
  Channel* channel(const std::string& name);
  const Channel* channel(const std::string& name) const;

  Channel fused_;
  Channel lidar_;
  Channel visual_;
  Channel octomap_;
  Channel cloud_;
  std::size_t damaged_ = 0;
};

}  // namespace fusion_slam
