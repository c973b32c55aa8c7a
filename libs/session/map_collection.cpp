#include "libs/session/map_collection.hpp"

#include <utility>

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

const MapCollection::Channel* MapCollection::channel(const std::string& name) const {
  if (name == "GRID_FUSED") return &fused_;
  if (name == "GRID_LIDAR") return &lidar_;
  if (name == "GRID_VISUAL") return &visual_;
  if (name == "OCTOMAP") return &octomap_;
  if (name == "CLOUD") return &cloud_;
  return nullptr;
}

MapCollection::Channel* MapCollection::channel(const std::string& name) {
  return const_cast<Channel*>(std::as_const(*this).channel(name));
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

std::optional<MapRaster> MapCollection::grid_of(const std::string& name, std::string* why) const {
  *why = "no " + name + " tile came";
  const Channel* tiles = channel(name);
  if (tiles == nullptr) return std::nullopt;
  const Provenance sensor = name == "GRID_LIDAR"    ? Provenance::kLidar
                            : name == "GRID_VISUAL" ? Provenance::kCamera
                                                    : Provenance::kNone;
  std::map<TileIndex, FusedCells> cells;
  double resolution_m = 0.0;
  for (const auto& [key, tile] : *tiles) {
    const auto decoded = decode_grid(tile, sensor);
    if (!decoded || (resolution_m > 0.0 && tile.resolution_m != resolution_m)) continue;
    resolution_m = tile.resolution_m;
    cells[{key.x, key.y}] = *decoded;
  }
  if (cells.empty()) return std::nullopt;
  return make_raster(cells, resolution_m, why);
}

std::optional<MapRaster> MapCollection::grid(std::string* source, std::string* why) const {
  std::string first_why = "no grid tile came";
  for (const char* name : {"GRID_FUSED", "GRID_LIDAR", "GRID_VISUAL"}) {
    if (channel(name)->empty()) continue;
    *source = name;
    if (auto raster = grid_of(name, why)) return raster;
    first_why = *why;
  }
  *why = first_why;
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
