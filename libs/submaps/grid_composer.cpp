#include "libs/submaps/grid_composer.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace fusion_slam {
namespace {

// However many submaps agree, the sum stays where the other sensor can still be heard.
constexpr double kLargestLogOdds = 3.9;  // probability 0.98

std::array<double, 256> make_log_odds() {
  std::array<double, 256> table{};
  for (int cell = 1; cell < 256; ++cell) {
    const double p = std::clamp(probability_from_cell(static_cast<std::uint8_t>(cell)), 0.02, 0.98);
    table[static_cast<std::size_t>(cell)] = std::log(p / (1.0 - p));
  }
  return table;
}

// Corners of a tile in its own frame.
std::array<Eigen::Vector2d, 4> corners_m(const TileIndex& index, double edge_m) {
  const Eigen::Vector2d low(index.first * edge_m, index.second * edge_m);
  return {low, low + Eigen::Vector2d(edge_m, 0), low + Eigen::Vector2d(0, edge_m),
          low + Eigen::Vector2d(edge_m, edge_m)};
}

// Reads neighbouring cells fast: remembers the tile of the last one. TiledGrid::at is the slow way.
class CellReader {
 public:
  explicit CellReader(const TiledGrid& grid) : grid_(grid) {}

  std::uint8_t at(const Eigen::Vector2d& p_m) {
    const int x = grid_.cell_of(p_m.x());
    const int y = grid_.cell_of(p_m.y());
    const TileIndex index{x >> 6, y >> 6};  // floor(cell / 64)
    if (!valid_ || index != index_) {
      const auto it = grid_.tiles().find(index);
      cells_ = it == grid_.tiles().end() ? nullptr : &it->second;
      index_ = index;
      valid_ = true;
    }
    if (cells_ == nullptr) return kUnknownCell;
    return (
        *cells_)[static_cast<std::size_t>(y & 63) * kTileCells + static_cast<std::size_t>(x & 63)];
  }

 private:
  const TiledGrid& grid_;
  const TileCells* cells_ = nullptr;
  TileIndex index_;
  bool valid_ = false;
};

}  // namespace

GridComposer::GridComposer(double resolution_m, double slack_cells)
    : map_(resolution_m), slack_m_(slack_cells * resolution_m) {}

void GridComposer::set_tile(std::int64_t submap_id, const TileIndex& index, const TileCells& cells,
                            double resolution_m) {
  Submap& submap = submaps_[submap_id];
  if (!submap.grid) submap.grid.emplace(resolution_m);
  submap.grid->tiles()[index] = cells;
  submap.changed.insert(index);
}

void GridComposer::erase_tile(std::int64_t submap_id, const TileIndex& index) {
  const auto it = submaps_.find(submap_id);
  if (it == submaps_.end() || !it->second.grid) return;
  if (it->second.grid->tiles().erase(index) != 0) it->second.changed.insert(index);
}

void GridComposer::set_pose(std::int64_t submap_id, const SE2& T_map_submap) {
  submaps_[submap_id].T_map_submap = T_map_submap;
}

bool GridComposer::needs_placing(const Submap& submap, bool exact) const {
  if (!submap.grid || !submap.T_map_submap) return false;
  if (!submap.placed) return true;
  const double edge_m = kTileCells * submap.grid->resolution_m();
  double moved_m = 0.0;
  for (const auto& [index, cells] : submap.grid->tiles())
    for (const Eigen::Vector2d& corner : corners_m(index, edge_m))
      moved_m =
          std::max(moved_m, ((*submap.T_map_submap) * corner - (*submap.placed) * corner).norm());
  return moved_m > (exact ? 0.0 : slack_m_);
}

// The map's tiles that a tile of a placed submap touches.
void GridComposer::mark(const Submap& submap, const TileIndex& own,
                        std::set<TileIndex>* dirty) const {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d high = -low;
  const double own_edge_m = kTileCells * submap.grid->resolution_m();
  for (const Eigen::Vector2d& corner : corners_m(own, own_edge_m)) {
    low = low.cwiseMin((*submap.placed) * corner);
    high = high.cwiseMax((*submap.placed) * corner);
  }
  const double edge_m = kTileCells * map_.resolution_m();
  const auto tile = [edge_m](double v) { return static_cast<int>(std::floor(v / edge_m)); };
  for (int x = tile(low.x()); x <= tile(high.x()); ++x)
    for (int y = tile(low.y()); y <= tile(high.y()); ++y) dirty->insert({x, y});
}

std::set<TileIndex> GridComposer::recompose(bool exact) {
  std::set<TileIndex> dirty;
  for (auto& [id, submap] : submaps_) {
    const auto mark_all = [&, &placed = submap] {
      for (const auto& [index, cells] : placed.grid->tiles()) mark(placed, index, &dirty);
    };
    if (submap.placed)  // also those that are gone
      for (const TileIndex& index : submap.changed) mark(submap, index, &dirty);
    if (needs_placing(submap, exact)) {
      if (submap.placed) mark_all();
      submap.placed = submap.T_map_submap;
      mark_all();
    } else if (submap.changed.empty() || !submap.placed) {
      continue;
    }
    submap.changed.clear();
    submap.covers.clear();
    for (const auto& [index, cells] : submap.grid->tiles()) mark(submap, index, &submap.covers);
  }
  for (const TileIndex& index : dirty) compose_tile(index);
  return dirty;
}

void GridComposer::compose_tile(const TileIndex& index) {
  static const std::array<double, 256> kLogOdds = make_log_odds();
  std::array<double, kTileCells * kTileCells> sum{};
  std::array<bool, kTileCells * kTileCells> known{};
  bool any = false;
  const double resolution_m = map_.resolution_m();
  for (const auto& [id, submap] : submaps_) {
    if (!submap.placed) continue;
    if (submap.covers.count(index) == 0) continue;
    const SE2 inverse = submap.placed->inverse();
    const Eigen::Matrix2d R = Eigen::Rotation2Dd(inverse.yaw).toRotationMatrix();
    const Eigen::Vector2d t(inverse.x, inverse.y);
    CellReader reader(*submap.grid);
    for (int y = 0; y < kTileCells; ++y) {
      for (int x = 0; x < kTileCells; ++x) {
        const Eigen::Vector2d p_map((index.first * kTileCells + x + 0.5) * resolution_m,
                                    (index.second * kTileCells + y + 0.5) * resolution_m);
        const std::uint8_t cell = reader.at(R * p_map + t);
        if (cell == kUnknownCell) continue;
        const auto i = static_cast<std::size_t>(y) * kTileCells + static_cast<std::size_t>(x);
        sum[i] += kLogOdds[cell];
        known[i] = any = true;
      }
    }
  }
  if (!any) {
    map_.tiles().erase(index);
    return;
  }
  TileCells& cells = map_.tiles()[index];
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double log_odds = std::clamp(sum[i], -kLargestLogOdds, kLargestLogOdds);
    cells[i] = known[i] ? cell_from_probability(1.0 / (1.0 + std::exp(-log_odds))) : kUnknownCell;
  }
}

}  // namespace fusion_slam
