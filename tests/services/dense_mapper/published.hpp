// What a dense mapper has published so far, as somebody has it who took every tile.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "services/dense_mapper/dense_mapper.hpp"

namespace fusion_slam {

struct Published {
  using Content = std::map<TileKey, std::vector<std::uint8_t>>;
  Content octomap, cloud, grid;

  void add(const DenseTiles& tiles) {
    add(tiles.octomap, &octomap);
    add(tiles.cloud, &cloud);
    add(tiles.grid, &grid);
  }
  bool operator==(const Published& other) const {
    return octomap == other.octomap && cloud == other.cloud && grid == other.grid;
  }

 private:
  static void add(const std::vector<Tile>& from, Content* to) {
    for (const Tile& tile : from) {
      if (tile.encoding == TileEncoding::kEmpty)
        to->erase(tile.key);
      else
        (*to)[tile.key] = tile.data;
    }
  }
};

}  // namespace fusion_slam
