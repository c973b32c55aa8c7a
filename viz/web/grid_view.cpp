#include "viz/web/grid_view.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

std::optional<FusedCells> decode(const Tile& tile, GridView::Layer layer) {
  if (layer == GridView::Layer::kFused) return decode_fused_tile(tile);
  const auto cells = decode_grid_tile(tile);
  if (!cells) return std::nullopt;
  FusedCells one;
  one.probability = *cells;
  const auto sensor = layer == GridView::Layer::kLidar ? Provenance::kLidar : Provenance::kCamera;
  for (std::size_t i = 0; i < cells->size(); ++i)
    if ((*cells)[i] != kUnknownCell) one.provenance[i] = static_cast<std::uint8_t>(sensor);
  return one;
}

}  // namespace

bool GridView::on_tile(Layer layer, const Tile& tile) {
  Tiles& tiles = layers_[static_cast<std::size_t>(layer)];
  if (tile.key.submap_id != 0 || !(tile.resolution_m > 1e-3 && tile.resolution_m < 100.0))
    return false;
  const TileIndex index{tile.key.x, tile.key.y};
  if (tile.encoding == TileEncoding::kEmpty) return tiles.erase(index), true;
  const auto fresh = decode(tile, layer);
  if (!fresh) return false;
  Cells& held = tiles[index];
  if (held.revision > tile.revision) return true;
  held.known = 0;
  for (std::size_t i = 0; i < fresh->probability.size(); ++i) {
    const bool known = fresh->probability[i] != kUnknownCell;
    held.known += known ? 1 : 0;
    if (fresh->probability[i] == held.cells.probability[i] &&
        fresh->provenance[i] == held.cells.provenance[i])
      continue;
    History& history = held.history[i];
    if (history.first_us == 0) history.first_us = tile.utime_us;
    history.changed_us = tile.utime_us;
    ++history.changes;
  }
  held.cells = *fresh;
  held.revision = tile.revision;
  held.resolution_m = tile.resolution_m;
  return true;
}

const GridView::Tiles* GridView::best() const {
  for (const Tiles& tiles : layers_)
    if (!tiles.empty()) return &tiles;
  return nullptr;
}

std::optional<CellReport> GridView::at(double x_m, double y_m) const {
  const Tiles* const first = best();
  if (first == nullptr || !std::isfinite(x_m) || !std::isfinite(y_m)) return std::nullopt;
  CellReport report;
  report.resolution_m = first->begin()->second.resolution_m;
  report.cell_x = static_cast<int>(std::floor(std::clamp(x_m / report.resolution_m, -1e9, 1e9)));
  report.cell_y = static_cast<int>(std::floor(std::clamp(y_m / report.resolution_m, -1e9, 1e9)));
  const auto tile_of = [](int cell) { return cell >= 0 ? cell / 64 : -((63 - cell) / 64); };
  const TileIndex index{tile_of(report.cell_x), tile_of(report.cell_y)};
  const int in_tile = (report.cell_y - index.second * 64) * 64 + (report.cell_x - index.first * 64);
  const auto i = static_cast<std::size_t>(in_tile);
  bool found = false;
  for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
    const auto tile = layers_[layer].find(index);
    if (tile == layers_[layer].end() || tile->second.resolution_m != report.resolution_m) continue;
    const std::uint8_t cell = tile->second.cells.probability[i];
    std::optional<double>* const outs[] = {&report.fused, &report.lidar, &report.visual};
    if (cell != kUnknownCell) *outs[layer] = probability_from_cell(cell);
    if (!found) {
      const History& history = tile->second.history[i];
      report.provenance = static_cast<Provenance>(tile->second.cells.provenance[i]);
      report.first_seen_us = history.first_us;
      report.last_changed_us = history.changed_us;
      report.changes = history.changes;
    }
    found = true;
  }
  return found ? std::optional(report) : std::nullopt;
}

double GridView::known_area_m2() const {
  const Tiles* const tiles = best();
  double area_m2 = 0.0;
  if (tiles != nullptr)
    for (const auto& [index, tile] : *tiles)
      area_m2 += tile.known * tile.resolution_m * tile.resolution_m;
  return area_m2;
}

}  // namespace fusion_slam
