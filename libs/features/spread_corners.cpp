#include "libs/features/spread_corners.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/features2d.hpp>

namespace fusion_slam {
namespace {

constexpr int kCornersPerCell =
    4;  // cells are made so large that a fully textured image fills its quota so

bool stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  if (a.response != b.response) return a.response > b.response;
  if (a.pt.y != b.pt.y) return a.pt.y < b.pt.y;
  return a.pt.x < b.pt.x;
}

// The cells that corners are spread over.
struct Cells {
  Cells(const cv::Size& size, int quota)
      : cell_px(
            std::max(8.0, std::sqrt(static_cast<double>(size.area()) * kCornersPerCell / quota))),
        columns(static_cast<int>(size.width / cell_px) + 1),
        rows(static_cast<int>(size.height / cell_px) + 1),
        corners(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}

  int along(float px) const { return static_cast<int>(px / cell_px); }
  std::size_t index_of(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  std::size_t index_of(const cv::KeyPoint& corner) const {
    return index_of(along(corner.pt.x), along(corner.pt.y));
  }
  std::vector<cv::KeyPoint>& at(int column, int row) { return corners[index_of(column, row)]; }
  // The first whole pixel of a column or row of cells.
  int begin_px(int cell) const {
    int px = static_cast<int>(cell * cell_px);
    while (along(static_cast<float>(px)) < cell) ++px;
    return px;
  }

  double cell_px;
  int columns;
  int rows;
  std::vector<std::vector<cv::KeyPoint>> corners;
};

// Corners below `usual` (down to `low`) of the cells of a row from `first` to before `last`, which
// have none above. FAST's ring reaches 3 pixels and its suppression of weaker neighbours one more:
// so far a corner is what it is in the whole image.
void fill_bare_cells(const cv::Mat& image, int low, int first, int last, int row, Cells* cells) {
  constexpr int kReach_px = 4;
  const int x0 = std::max(0, cells->begin_px(first) - kReach_px);
  const int x1 = std::min(image.cols, cells->begin_px(last) + kReach_px);
  const int y0 = std::max(0, cells->begin_px(row) - kReach_px);
  const int y1 = std::min(image.rows, cells->begin_px(row + 1) + kReach_px);
  if (x1 - x0 < 7 || y1 - y0 < 7) return;  // no room for a ring
  std::vector<cv::KeyPoint> found;
  cv::FAST(image(cv::Rect(x0, y0, x1 - x0, y1 - y0)), found, low, true);
  for (cv::KeyPoint& corner : found) {
    corner.pt += cv::Point2f(static_cast<float>(x0), static_cast<float>(y0));
    const int column = cells->along(corner.pt.x);
    if (cells->along(corner.pt.y) == row && column >= first && column < last)
      cells->at(column, row).push_back(corner);
  }
}

// FAST corners at threshold `usual`, and at `low` where a cell has none: of a whole image's corners
// at `low` those that spread_corners() looks at. A corner's response is the largest threshold at
// which it is one, so the stronger are found by the higher threshold alone.
void find_corners(const cv::Mat& image, int usual, int low, Cells* cells) {
  std::vector<cv::KeyPoint> found;
  cv::FAST(image, found, usual, true);
  std::vector<std::size_t> count(cells->corners.size(), 0);
  for (const cv::KeyPoint& corner : found) ++count[cells->index_of(corner)];
  for (std::size_t i = 0; i < count.size(); ++i) cells->corners[i].reserve(count[i]);
  for (const cv::KeyPoint& corner : found)
    cells->corners[cells->index_of(corner)].push_back(corner);
  if (low >= usual) return;
  for (int row = 0; row < cells->rows; ++row)
    for (int first = 0; first < cells->columns; ++first) {
      int last = first;
      while (last < cells->columns && cells->at(last, row).empty()) ++last;
      if (last == first) continue;
      fill_bare_cells(image, low, first, last, row, cells);
      first = last;
    }
}

// A full image takes a few of each cell, which may hold a hundred: the next few are put in order.
constexpr std::size_t kSortedAtOnce = 8;

void sort_next(std::size_t from, std::vector<cv::KeyPoint>* cell) {
  const auto begin = cell->begin() + static_cast<std::ptrdiff_t>(from);
  const std::size_t n = std::min(kSortedAtOnce, cell->size() - from);
  std::partial_sort(begin, begin + static_cast<std::ptrdiff_t>(n), cell->end(), stronger);
}

}  // namespace

std::vector<cv::KeyPoint> spread_corners(const cv::Mat& image, int quota, int usual, int low) {
  Cells found(image.size(), quota);
  find_corners(image, usual, low, &found);
  std::vector<cv::KeyPoint> kept, rank;  // rank: the k-th strongest of each cell
  for (std::size_t k = 0; kept.size() < static_cast<std::size_t>(quota); ++k) {
    rank.clear();
    for (auto& cell : found.corners) {
      if (k >= cell.size()) continue;
      if (k % kSortedAtOnce == 0) sort_next(k, &cell);
      if (k > 0 && cell[k].response < static_cast<float>(usual))
        continue;  // weak ones only where nothing else is
      rank.push_back(cell[k]);
    }
    if (rank.empty()) break;
    const std::size_t room = static_cast<std::size_t>(quota) - kept.size();
    if (rank.size() > room) {
      std::sort(rank.begin(), rank.end(), stronger);
      rank.resize(room);
    }
    kept.insert(kept.end(), rank.begin(), rank.end());
  }
  return kept;
}

}  // namespace fusion_slam
