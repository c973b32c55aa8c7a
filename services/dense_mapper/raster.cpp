#include "services/dense_mapper/raster.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr int kUnseenSteps = 32;     // log-odds 1
constexpr double kGapBelowM = 0.10;  // seen free below an overhang
constexpr double kWidestM = 0.45;    // of a seat or a shelf
constexpr double kInferred = 0.7;

std::uint8_t cell_of(int highest, int sum, int seen, int voxels) {
  if (seen == 0) return kUnknownCell;
  const double mean = (sum + kUnseenSteps * (voxels - seen)) / static_cast<double>(voxels);
  const double steps = highest > 0 ? highest : std::min(mean, 0.0);
  return cell_from_probability(1.0 / (1.0 + std::exp(-steps * kLogOddsStep)));
}

// Bits above the lowest run of `gap` free ones.
std::uint32_t above_gap(std::uint32_t free, int gap) {
  std::uint32_t runs = free;
  for (int i = 1; i < gap; ++i) runs &= free >> i;
  if (runs == 0) return 0;
  const std::uint32_t lowest = runs & (~runs + 1);
  const std::uint32_t upto = lowest | (lowest - 1);
  return gap >= 32 ? 0 : ~((upto << (gap - 1)) | ((1U << (gap - 1)) - 1));
}

// Reads cells of neighbouring columns; beyond them nothing is known.
class BandReader {
 public:
  BandReader(const ColumnRasters& rasters, const ColumnIndex& centre) {
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const auto it = rasters.find({centre.first + dx, centre.second + dy});
        const int i = (dy + 1) * 3 + dx + 1;
        around_[static_cast<std::size_t>(i)] = it == rasters.end() ? nullptr : &it->second;
      }
  }
  // x, y of the centre column's cells, -32 ... 63.
  // Occupied voxels with free space below them: of a wall there are none.
  std::uint32_t rim(int x, int y, int gap) const {
    const ColumnRaster* column = at(x, y);
    if (column == nullptr) return 0;
    const std::uint32_t occupied = column->occupied(cell(x, y));
    if (occupied == 0) return 0;
    return occupied & above_gap(column->known(cell(x, y)) & ~occupied, gap);
  }
  std::uint32_t occupied(int x, int y) const {
    const ColumnRaster* column = at(x, y);
    return column == nullptr ? 0 : column->occupied(cell(x, y));
  }
  std::uint32_t known(int x, int y) const {
    const ColumnRaster* column = at(x, y);
    return column == nullptr ? 0 : column->known(cell(x, y));
  }

 private:
  const ColumnRaster* at(int x, int y) const {
    const int i = ((y >> 5) + 1) * 3 + (x >> 5) + 1;
    return around_[static_cast<std::size_t>(i)];
  }
  static std::size_t cell(int x, int y) {
    return static_cast<std::size_t>(y & 31) * kOctomapTileVoxels + static_cast<std::size_t>(x & 31);
  }
  std::array<const ColumnRaster*, 9> around_{};
};

struct Reach {  // in cells
  int along = 9;
  int gap = 2;
};

// Of `wanted`, the voxels from which the first known one along (dx, dy) is a rim: by the number of
// steps to it.
std::uint32_t bounded(const BandReader& band, int x, int y, int dx, int dy, const Reach& reach,
                      std::uint32_t wanted, std::vector<std::uint32_t>* at_step) {
  std::uint32_t open = wanted;
  std::uint32_t found = 0;
  for (int i = 1; i <= reach.along && open != 0; ++i) {
    const int xx = x + i * dx, yy = y + i * dy;
    const std::uint32_t known = band.known(xx, yy);
    (*at_step)[static_cast<std::size_t>(i)] = open & band.rim(xx, yy, reach.gap);
    found |= (*at_step)[static_cast<std::size_t>(i)];
    open &= ~known;
  }
  return found;
}

// `wanted`: unseen voxels with free space below; `sandwiched`: those of them with some above too.
bool overhang(const BandReader& band, int x, int y, const Reach& reach, std::uint32_t wanted,
              std::uint32_t sandwiched) {
  std::vector<std::uint32_t> left(static_cast<std::size_t>(reach.along) + 1);
  std::vector<std::uint32_t> right(left.size());
  for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(0, 1)}) {
    std::fill(left.begin(), left.end(), 0);
    std::fill(right.begin(), right.end(), 0);
    const std::uint32_t on_left = bounded(band, x, y, -dx, -dy, reach, wanted, &left);
    const std::uint32_t on_right = bounded(band, x, y, dx, dy, reach, wanted, &right);
    if (((on_left | on_right) & sandwiched) != 0) return true;
    if ((on_left & on_right) == 0) continue;
    for (std::size_t i = 1; i < left.size(); ++i)
      for (std::size_t j = 1; i + j <= left.size(); ++j)
        if ((left[i] & right[j]) != 0) return true;
  }
  return false;
}

// Unseen voxels with free space above them and on all four sides first an occupied one.
bool under_a_top(const BandReader& band, int x, int y, std::uint32_t wanted) {
  for (const auto& [dx, dy] :
       {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
    std::uint32_t open = wanted;
    std::uint32_t found = 0;
    for (int i = 1; i < kOctomapTileVoxels && open != 0; ++i) {
      found |= open & band.occupied(x + i * dx, y + i * dy);
      open &= ~band.known(x + i * dx, y + i * dy);
    }
    wanted = found;
    if (wanted == 0) return false;
  }
  return true;
}

// Bits below the highest one that is set.
std::uint32_t below_highest(std::uint32_t bits) {
  for (int shift = 1; shift < 32; shift *= 2) bits |= bits >> shift;
  return bits >> 1;
}

}  // namespace

std::uint8_t raster_cell(const std::vector<std::int8_t>& column) {
  std::int8_t highest = kUnknownVoxel;
  int sum = 0;
  int seen = 0;
  for (const std::int8_t steps : column) {
    if (steps == kUnknownVoxel) continue;
    highest = std::max(highest, steps);
    sum += steps;
    ++seen;
  }
  return cell_of(highest, sum, seen, static_cast<int>(column.size()));
}

Band band_between(double low_m, double high_m, double resolution_m) {
  // 1e-6: 0.05 / 0.05 isn't always 1.
  Band band;
  band.from = static_cast<int>(std::ceil(low_m / resolution_m - 0.5 - 1e-6));
  band.to = static_cast<int>(std::ceil(high_m / resolution_m - 0.5 - 1e-6));
  band.to = std::max(band.to, band.from + 1);
  return band;
}

ColumnRaster::ColumnRaster() {
  highest_.fill(kUnknownVoxel);
  sum_.fill(0);
  seen_.fill(0);
  occupied_.fill(0);
  known_.fill(0);
}

void ColumnRaster::add(const VoxelCells& cube, int from_slice, int to_slice, int first) {
  for (int z = from_slice; z < to_slice; ++z) {
    const std::int8_t* slice = cube.data() + voxel_index(0, 0, z);
    const int voxel = first + z - from_slice;
    const std::uint32_t bit = voxel < 32 ? 1U << voxel : 0U;
    for (std::size_t i = 0; i < highest_.size(); ++i) {
      const std::int8_t steps = slice[i];
      if (steps == kUnknownVoxel) continue;
      highest_[i] = std::max(highest_[i], steps);
      sum_[i] = static_cast<std::int16_t>(sum_[i] + steps);
      ++seen_[i];
      known_[i] |= bit;
      if (steps > 0) occupied_[i] |= bit;
    }
  }
}

std::uint8_t ColumnRaster::cell(std::size_t i, int band_voxels) const {
  return cell_of(highest_[i], sum_[i], seen_[i], band_voxels);
}

ColumnCells raster_column(const ColumnRasters& rasters, const ColumnIndex& index, int band_voxels,
                          double resolution_m) {
  const ColumnRaster& own = rasters.at(index);
  const BandReader band(rasters, index);
  Reach reach;
  reach.gap = std::max(1, static_cast<int>(std::lround(kGapBelowM / resolution_m)));
  reach.along =
      std::clamp(static_cast<int>(std::lround(kWidestM / resolution_m)), 1, kOctomapTileVoxels);
  const std::uint32_t all = band_voxels >= 32 ? ~0U : (1U << band_voxels) - 1;
  ColumnCells cells;
  for (int y = 0; y < kOctomapTileVoxels; ++y)
    for (int x = 0; x < kOctomapTileVoxels; ++x) {
      const auto i = static_cast<std::size_t>(y) * kOctomapTileVoxels + static_cast<std::size_t>(x);
      cells[i] = own.cell(i, band_voxels);
      if (own.occupied(i) != 0 || own.known(i) == 0) continue;
      const std::uint32_t unseen = ~own.known(i) & all;
      const std::uint32_t seen_above = unseen & below_highest(own.known(i));
      const std::uint32_t wanted = unseen & above_gap(own.known(i), reach.gap);
      if ((wanted != 0 && overhang(band, x, y, reach, wanted, wanted & seen_above)) ||
          (seen_above != 0 && under_a_top(band, x, y, seen_above)))
        cells[i] = cell_from_probability(kInferred);
    }
  return cells;
}

}  // namespace fusion_slam
