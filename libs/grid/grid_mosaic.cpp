#include "libs/grid/grid_mosaic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace fusion_slam {
namespace {

constexpr std::int16_t kNothing = INT16_MIN;
constexpr double kUnit = 1.0 / 256.0;  // log-odds; a cell's byte is coarser
// However many submaps agree, the sum stays where the other sensor can still be heard.
constexpr int kLargest = 998;  // 3.9: probability 0.98
constexpr int kShift = 16;     // cells, fixed point
// The newest submaps of a tile still grow: the base ends below them.
constexpr std::size_t kGrowing = 2;
constexpr std::size_t kWorthABase = 2;  // submaps in it
constexpr std::size_t kOpen = 4;        // submaps that are not packed: those that may grow
constexpr std::size_t kCells = static_cast<std::size_t>(kTileCells) * kTileCells;

std::array<std::int16_t, 256> make_log_odds() {
  std::array<std::int16_t, 256> table{};
  table[kUnknownCell] = kNothing;
  for (int cell = 1; cell < 256; ++cell) {
    const double p = std::clamp(probability_from_cell(static_cast<std::uint8_t>(cell)), 0.02, 0.98);
    const auto units = static_cast<int>(std::lround(std::log(p / (1.0 - p)) / kUnit));
    table[static_cast<std::size_t>(cell)] =
        static_cast<std::int16_t>(std::clamp(units, -kLargest, kLargest));
  }
  return table;
}

std::array<std::uint8_t, 2 * kLargest + 1> make_bytes() {
  std::array<std::uint8_t, 2 * kLargest + 1> table{};
  std::size_t at = 0;
  for (int i = -kLargest; i <= kLargest; ++i)
    table[at++] = cell_from_probability(1.0 / (1.0 + std::exp(-i * kUnit)));
  return table;
}

std::size_t cell_at(int x, int y) {
  return static_cast<std::size_t>(y) * kTileCells + static_cast<std::size_t>(x);
}

// Corners of a box of cells of a tile, in the grid's own frame.
std::array<Eigen::Vector2d, 4> corners_m(const TileIndex& index, const CellBox& box,
                                         double resolution_m) {
  const double x0 = (index.first * kTileCells + box.x0) * resolution_m;
  const double x1 = (index.first * kTileCells + box.x1) * resolution_m;
  const double y0 = (index.second * kTileCells + box.y0) * resolution_m;
  const double y1 = (index.second * kTileCells + box.y1) * resolution_m;
  return {Eigen::Vector2d(x0, y0), Eigen::Vector2d(x1, y0), Eigen::Vector2d(x0, y1),
          Eigen::Vector2d(x1, y1)};
}

constexpr CellBox kWhole{0, 0, kTileCells, kTileCells};

CellBox difference(const TileCells& a, const TileCells& b) {
  CellBox box;
  for (int y = 0; y < kTileCells; ++y)
    for (int x = 0; x < kTileCells; ++x)
      if (a[cell_at(x, y)] != b[cell_at(x, y)]) box.include({x, y, x + 1, y + 1});
  return box;
}

}  // namespace

void CellBox::include(const CellBox& other) {
  x0 = std::min(x0, other.x0);
  y0 = std::min(y0, other.y0);
  x1 = std::max(x1, other.x1);
  y1 = std::max(y1, other.y1);
}

GridMosaic::GridMosaic(double resolution_m, double slack_cells)
    : map_(resolution_m), slack_m_(slack_cells * resolution_m) {}

void GridMosaic::set_tile(std::int64_t submap_id, const TileIndex& index, const TileCells& cells,
                          double resolution_m) {
  Submap& submap = submaps_[submap_id];
  if (!submap.grid) submap.grid = Grid{resolution_m, {}};
  const auto [it, made] = submap.grid->tiles.try_emplace(index);
  if (made)
    it->second.open = std::make_unique<TileCells>(cells);
  else
    open(&it->second);
  open_.insert(submap_id);
  const CellBox box = made ? kWhole : difference(*it->second.open, cells);
  if (box.empty()) return;
  *it->second.open = cells;
  submap.changed[index].include(box);
}

void GridMosaic::erase_tile(std::int64_t submap_id, const TileIndex& index) {
  const auto it = submaps_.find(submap_id);
  if (it == submaps_.end() || !it->second.grid) return;
  if (it->second.grid->tiles.erase(index) != 0) it->second.changed[index] = kWhole;
}

void GridMosaic::open(Cells* cells) {
  if (cells->open) return;
  cells->open = std::make_unique<TileCells>();
  if (const auto raw =
          inflate_bytes(cells->packed.data(), cells->packed.size(), cells->open->size()))
    std::copy(raw->begin(), raw->end(), cells->open->begin());  // all: deflated by pack_old()
  cells->packed = {};
}

void GridMosaic::pack_old() {
  while (open_.size() > kOpen) {
    for (auto& [index, cells] : submaps_.at(*open_.begin()).grid->tiles) {
      if (!cells.open) continue;
      cells.packed =
          deflate_bytes(std::vector<std::uint8_t>(cells.open->begin(), cells.open->end()));
      cells.packed.shrink_to_fit();
      cells.open.reset();
    }
    open_.erase(open_.begin());
  }
}

std::size_t GridMosaic::submap_bytes() const {
  std::size_t sum = 0;
  for (const auto& [id, submap] : submaps_) {
    if (!submap.grid) continue;
    for (const auto& [index, cells] : submap.grid->tiles)
      sum += cells.open ? cells.open->size() : cells.packed.size();
  }
  return sum;
}

void GridMosaic::set_pose(std::int64_t submap_id, const SE2& T_map_submap) {
  submaps_[submap_id].T_map_submap = T_map_submap;
}

bool GridMosaic::needs_placing(const Submap& submap, bool exact) const {
  if (!submap.grid || !submap.T_map_submap) return false;
  if (!submap.placed) return true;
  const SE2 &a = *submap.T_map_submap, &b = *submap.placed;
  if (a.x == b.x && a.y == b.y && a.yaw == b.yaw) return false;
  double moved_m = 0.0;
  for (const auto& [index, cells] : submap.grid->tiles)
    for (const Eigen::Vector2d& corner : corners_m(index, kWhole, submap.grid->resolution_m))
      moved_m = std::max(moved_m, (a * corner - b * corner).norm());
  return moved_m > (exact ? 0.0 : slack_m_);
}

// The map's cells that cells of a placed submap touch.
void GridMosaic::mark(std::int64_t id, const Submap& submap, const TileIndex& own,
                      const CellBox& cells, Dirty* dirty) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d high = -low;
  for (const Eigen::Vector2d& corner : corners_m(own, cells, submap.grid->resolution_m)) {
    low = low.cwiseMin(*submap.placed * corner);
    high = high.cwiseMax(*submap.placed * corner);
  }
  const auto cell = [this](double v) { return map_.cell_of(v); };
  // One more on each side: rounding must not decide.
  const int x0 = cell(low.x()) - 1, x1 = cell(high.x()) + 2;
  const int y0 = cell(low.y()) - 1, y1 = cell(high.y()) + 2;
  for (int tx = x0 >> 6; tx <= (x1 - 1) >> 6; ++tx)
    for (int ty = y0 >> 6; ty <= (y1 - 1) >> 6; ++ty) {
      const int left = tx * kTileCells, bottom = ty * kTileCells;
      (*dirty)[{tx, ty}].include({std::max(0, x0 - left), std::max(0, y0 - bottom),
                                  std::min(kTileCells, x1 - left),
                                  std::min(kTileCells, y1 - bottom)});
      const auto base = bases_.find({tx, ty});
      if (base != bases_.end() && id < base->second.upto) bases_.erase(base);
    }
}

void GridMosaic::cover(Submap* submap) {
  submap->covers.clear();
  Dirty touched;
  for (const auto& [index, cells] : submap->grid->tiles)
    mark(INT64_MAX, *submap, index, kWhole, &touched);
  for (const auto& [index, box] : touched) submap->covers.insert(index);
}

std::set<TileIndex> GridMosaic::recompose(bool exact) {
  Dirty dirty;
  for (auto& [id, submap] : submaps_) {
    const bool place = needs_placing(submap, exact);
    if (!place && (submap.changed.empty() || !submap.placed)) continue;
    if (submap.placed)  // also tiles that are gone
      for (const auto& [index, box] : submap.changed) mark(id, submap, index, box, &dirty);
    if (place) {
      if (submap.placed)
        for (const auto& [index, cells] : submap.grid->tiles)
          mark(id, submap, index, kWhole, &dirty);
      submap.placed = submap.T_map_submap;
      for (const auto& [index, cells] : submap.grid->tiles) mark(id, submap, index, kWhole, &dirty);
    }
    submap.changed.clear();
    for (const TileIndex& index : submap.covers) covered_by_[index].erase(id);
    cover(&submap);
    for (const TileIndex& index : submap.covers) covered_by_[index].insert(id);
  }
  std::set<TileIndex> changed;
  for (const auto& [index, box] : dirty)
    if (compose_tile(index, box)) changed.insert(index);
  pack_old();
  return changed;
}

bool GridMosaic::compose_tile(const TileIndex& index, const CellBox& box) {
  static const auto kBytes = make_bytes();
  const std::set<std::int64_t>& ids = covered_by_[index];
  auto next = ids.begin();
  Sums sums;
  if (ids.size() >= kGrowing + kWorthABase) {
    const auto end = std::prev(ids.end(), kGrowing);
    Base& base = bases_[index];
    if (base.sums.empty()) base.sums.assign(kCells, kNothing);
    if (base.upto < *end) {  // else submaps above have left
      for (auto it = ids.lower_bound(base.upto); it != end; ++it)
        add(submaps_.at(*it), index, kWhole, &base.sums);
      base.upto = *end;
    }
    sums = base.sums;
    next = ids.lower_bound(base.upto);
  } else {
    bases_.erase(index);
    sums.assign(kCells, kNothing);
  }
  for (; next != ids.end(); ++next) add(submaps_.at(*next), index, box, &sums);

  const auto [tile, made] = map_.tiles().try_emplace(index);
  if (made) tile->second.fill(kUnknownCell);
  TileCells& cells = tile->second;
  bool changed = false;
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) {
      const std::size_t i = cell_at(x, y);
      const int above_least = sums[i] + kLargest;
      const std::uint8_t cell =
          sums[i] == kNothing ? kUnknownCell : kBytes[static_cast<std::size_t>(above_least)];
      changed |= cells[i] != cell;
      cells[i] = cell;
    }
  if (std::all_of(cells.begin(), cells.end(), [](std::uint8_t c) { return c == kUnknownCell; }))
    map_.tiles().erase(tile);
  return changed;
}

void GridMosaic::add(const Submap& submap, const TileIndex& index, const CellBox& box,
                     Sums* sums) const {
  static const auto kLogOdds = make_log_odds();
  const double scale = 1.0 / submap.grid->resolution_m;
  const SE2 inverse = submap.placed->inverse();
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(inverse.yaw).toRotationMatrix();
  const Eigen::Vector2d t(inverse.x, inverse.y);
  const double r = map_.resolution_m();
  // In cells of the submap: the way from one map cell to the next.
  const double one = static_cast<double>(1 << kShift);
  const auto fixed = [one](double v) { return static_cast<std::int64_t>(std::llround(v * one)); };
  const std::int64_t step_x = fixed(R(0, 0) * r * scale);
  const std::int64_t step_y = fixed(R(1, 0) * r * scale);
  std::map<TileIndex, Cells> opened;  // of a packed submap: a few lie below a tile of the map
  TileIndex held{INT32_MAX, INT32_MAX};
  const TileCells* cells = nullptr;
  for (int y = box.y0; y < box.y1; ++y) {
    // From the tile's first cell on: where a cell looks must not depend on the box.
    const Eigen::Vector2d p_map((index.first * kTileCells + 0.5) * r,
                                (index.second * kTileCells + y + 0.5) * r);
    const Eigen::Vector2d p = (R * p_map + t) * scale;
    if (!(p.cwiseAbs().maxCoeff() < 1e9)) return;
    std::int64_t px = fixed(p.x()) + box.x0 * step_x;
    std::int64_t py = fixed(p.y()) + box.x0 * step_y;
    std::int16_t* sum = sums->data() + cell_at(box.x0, y);
    for (int x = box.x0; x < box.x1; ++x, ++sum, px += step_x, py += step_y) {
      const auto i = static_cast<std::int32_t>(px >> kShift);
      const auto j = static_cast<std::int32_t>(py >> kShift);
      if ((i >> 6) != held.first || (j >> 6) != held.second) {
        held = {i >> 6, j >> 6};
        const auto it = submap.grid->tiles.find(held);
        cells = it == submap.grid->tiles.end() ? nullptr : it->second.open.get();
        if (it != submap.grid->tiles.end() && cells == nullptr) {
          Cells& copy = opened[held];
          if (!copy.open) copy.packed = it->second.packed;
          open(&copy);
          cells = copy.open.get();
        }
      }
      if (cells == nullptr) continue;
      const std::int16_t says = kLogOdds[(*cells)[cell_at(i & 63, j & 63)]];
      if (says == kNothing) continue;
      const int both = (*sum == kNothing ? 0 : *sum) + says;
      *sum = static_cast<std::int16_t>(std::clamp(both, -kLargest, kLargest));
    }
  }
}

}  // namespace fusion_slam
