#include "libs/session/map_collection.hpp"

#include "libs/octree/octomap_tile.hpp"

namespace fusion_slam {
namespace {

// A grid of one sensor as a fused one: what is known is known from that sensor.
FusedCells of_one_sensor(const TileCells& cells, Provenance sensor) {
  FusedCells fused;
  fused.probability = cells;
  for (std::size_t i = 0; i < cells.size(); ++i)
    fused.provenance[i] =
        static_cast<std::uint8_t>(cells[i] == kUnknownCell ? Provenance::kNone : sensor);
  return fused;
}

std::optional<FusedCells> decode_grid(const Tile& tile, Provenance sensor) {
  if (tile.encoding == TileEncoding::kGridFused) return decode_fused_tile(tile);
  const auto cells = decode_grid_tile(tile);
  if (!cells) return std::nullopt;
  return of_one_sensor(*cells, sensor);
}

bool decodable(const Tile& tile) {
  switch (tile.encoding) {
    case TileEncoding::kEmpty:
      return true;
    case TileEncoding::kGridProbability:
      return decode_grid_tile(tile).has_value();
    case TileEncoding::kGridFused:
      return decode_fused_tile(tile).has_value();
    case TileEncoding::kOctomap:
      return decode_octomap_cells(tile).has_value();
    case TileEncoding::kCloud:
      return decode_cloud_tile(tile).has_value();
  }
  return false;
}

}  // namespace

MapCollection::Channel* MapCollection::channel(const std::string& name) {
  if (name == "GRID_FUSED") return &fused_;
  if (name == "GRID_LIDAR") return &lidar_;
  if (name == "GRID_VISUAL") return &visual_;
  if (name == "OCTOMAP") return &octomap_;
  if (name == "CLOUD") return &cloud_;
  return nullptr;
}

// An empty tile is kept as such, so that a late older revision of it can't come back.
void MapCollection::add(const std::string& name, const Tile& tile) {
  Channel* tiles = channel(name);
  if (tiles == nullptr || tile.key.submap_id != 0) return;
  const auto held = tiles->find(tile.key);
  if (held != tiles->end() && held->second.revision >= tile.revision) return;
  if (!(tile.resolution_m > 0.0 && tile.resolution_m < 100.0) || !decodable(tile)) {
    ++damaged_;
    return;
  }
  (*tiles)[tile.key] = tile;
}

std::optional<MapRaster> MapCollection::grid(std::string* source, std::string* why) const {
  struct Choice {
    const char* name;
    const Channel& tiles;
    Provenance sensor;
  };
  *why = "no grid tile came";
  for (const Choice& choice : {Choice{"GRID_FUSED", fused_, Provenance::kNone},
                               Choice{"GRID_LIDAR", lidar_, Provenance::kLidar},
                               Choice{"GRID_VISUAL", visual_, Provenance::kCamera}}) {
    std::map<TileIndex, FusedCells> cells;
    double resolution_m = 0.0;
    for (const auto& [key, tile] : choice.tiles) {
      const auto decoded = decode_grid(tile, choice.sensor);
      if (!decoded || (resolution_m > 0.0 && tile.resolution_m != resolution_m)) continue;
      resolution_m = tile.resolution_m;
      cells[{key.x, key.y}] = *decoded;
    }
    if (cells.empty()) continue;
    *source = choice.name;
    if (auto raster = make_raster(cells, resolution_m, why)) return raster;
  }
  return std::nullopt;
}

std::vector<ColouredPoint> MapCollection::cloud() const {
  std::vector<ColouredPoint> points;
  for (const auto& [key, tile] : cloud_) {
    const auto decoded = decode_cloud_tile(tile);
    if (decoded) points.insert(points.end(), decoded->begin(), decoded->end());
  }
  return points;
}

}  // namespace fusion_slam
