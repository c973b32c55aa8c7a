#include "libs/evaluation/map_score.hpp"

#include <algorithm>
#include <cmath>

#include "libs/evaluation/alignment.hpp"
#include "libs/evaluation/association.hpp"

namespace fusion_slam {
namespace {

double ratio(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

CellState reference_at(const MapRaster& raster, int column, int row) {
  if (column < 0 || row < 0 || column >= raster.width || row >= raster.height)
    return CellState::kUnknown;
  return state_of_cell(raster.probability[raster.index(column, row)]);
}

// Least squares in x, y and yaw: positions on one line, a straight drive, are enough for that.
Outcome<Similarity> align_in_plane(const MatchedPoses& matched, const std::string& otherwise) {
  Eigen::Vector2d from = Eigen::Vector2d::Zero(), to = Eigen::Vector2d::Zero();
  const double n = static_cast<double>(matched.size());
  const auto position = [](const StampedPose& p) -> Eigen::Vector2d {
    return p.T_world_body.translation().head<2>();
  };
  for (std::size_t i = 0; i < matched.size(); ++i) {
    from += position(matched.estimate[i]) / n;
    to += position(matched.reference[i]) / n;
  }
  double dot = 0.0, cross = 0.0, spread = 0.0;
  for (std::size_t i = 0; i < matched.size(); ++i) {
    const Eigen::Vector2d a = position(matched.estimate[i]) - from;
    const Eigen::Vector2d b = position(matched.reference[i]) - to;
    dot += a.dot(b);
    cross += a.x() * b.y() - a.y() * b.x();
    spread += a.squaredNorm() / n;
  }
  constexpr double kLeastSpread_m = 0.1;
  if (spread < kLeastSpread_m * kLeastSpread_m) return Outcome<Similarity>::failure(otherwise);
  const double yaw = std::atan2(cross, dot);
  const Eigen::Vector2d shift = to - Eigen::Rotation2Dd(yaw) * from;
  return Outcome<Similarity>::success({1.0, to_se3(SE2{shift.x(), shift.y(), yaw})});
}

// A square of (2 * tolerance + 1) cells around every occupied cell, in two passes.
class Dilated {
 public:
  template <class IsOccupied>
  Dilated(int first_column, int first_row, int width, int height, int tolerance, IsOccupied is)
      : left_(first_column - tolerance),
        low_(first_row - tolerance),
        width_(width + 2 * tolerance),
        height_(height + 2 * tolerance),
        near_(std::size_t(width_) * std::size_t(height_), false) {
    std::vector<bool> wide(near_.size(), false);
    for (int row = 0; row < height; ++row)
      for (int column = 0; column < width; ++column)
        if (is(first_column + column, first_row + row))
          for (int d = 0; d <= 2 * tolerance; ++d) wide[index(column + d, row + tolerance)] = true;
    for (int row = 0; row < height; ++row)
      for (int column = 0; column < width_; ++column)
        if (wide[index(column, row + tolerance)])
          for (int d = 0; d <= 2 * tolerance; ++d) near_[index(column, row + d)] = true;
  }
  bool at(int column, int row) const {
    column -= left_;
    row -= low_;
    return column >= 0 && row >= 0 && column < width_ && row < height_ && near_[index(column, row)];
  }

 private:
  std::size_t index(int column, int row) const {
    return std::size_t(row) * std::size_t(width_) + std::size_t(column);
  }
  int left_, low_, width_, height_;
  std::vector<bool> near_;
};

}  // namespace

Outcome<MapAlignment> align_maps(const Trajectory& reference, const Trajectory& estimate,
                                 double max_diff_s) {
  const auto matched = match_poses(reference, estimate, max_diff_s);
  if (!matched) return Outcome<MapAlignment>::failure(matched.problem);
  auto similarity = find_alignment(*matched, Alignment::kSe3);
  if (!similarity) similarity = align_in_plane(*matched, similarity.problem);
  if (!similarity) return Outcome<MapAlignment>::failure(similarity.problem);
  MapAlignment alignment;
  alignment.T_ref_est = to_se2(similarity->T_to_from);
  const double up = similarity->T_to_from.linear()(2, 2);
  alignment.tilt_rad = std::acos(std::clamp(up, -1.0, 1.0));
  alignment.matched = matched->size();
  double squares = 0.0;
  for (std::size_t i = 0; i < matched->size(); ++i)
    squares += (*similarity * matched->estimate[i].T_world_body.translation() -
                matched->reference[i].T_world_body.translation())
                   .squaredNorm();
  alignment.rmse_m = std::sqrt(squares / static_cast<double>(matched->size()));
  return Outcome<MapAlignment>::success(alignment);
}

CellState ResampledMap::at(int column, int row) const {
  column -= first_column;
  row -= first_row;
  if (column < 0 || row < 0 || column >= width || row >= height) return CellState::kUnknown;
  return cells[std::size_t(row) * std::size_t(width) + std::size_t(column)];
}

Outcome<ResampledMap> resample(const MapRaster& reference, const MapRaster& estimate,
                               const SE2& T_ref_est) {
  const double step = reference.resolution_m;
  const auto cell_of = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector2i(int(std::floor((p.x() - reference.origin_x_m) / step)),
                           int(std::floor((p.y() - reference.origin_y_m) / step)));
  };
  const auto in_reference = [&](double column, double row) {
    return T_ref_est * Eigen::Vector2d(estimate.origin_x_m + column * estimate.resolution_m,
                                       estimate.origin_y_m + row * estimate.resolution_m);
  };
  Eigen::Vector2i low(0, 0), high(reference.width - 1, reference.height - 1);
  for (const int column : {0, estimate.width})
    for (const int row : {0, estimate.height}) {
      const Eigen::Vector2d corner = in_reference(column, row);
      low = low.cwiseMin(cell_of(corner));
      // A map that ends on a cell's edge doesn't reach into the next.
      high = high.cwiseMax(cell_of(corner - Eigen::Vector2d::Constant(1e-6 * step)));
    }
  const double cells = (double(high.x()) - low.x() + 1.0) * (double(high.y()) - low.y() + 1.0);
  const int parts = std::max(1, int(std::ceil(estimate.resolution_m / step - 1e-9)));
  if (!(cells < double(1 << 27)) || parts > 64)
    return Outcome<ResampledMap>::failure(
        "on the reference's cells the estimated map is too large; are both resolutions and the "
        "alignment right?");
  ResampledMap map;
  map.first_column = low.x();
  map.first_row = low.y();
  map.width = high.x() - low.x() + 1;
  map.height = high.y() - low.y() + 1;
  map.cells.assign(std::size_t(map.width) * std::size_t(map.height), CellState::kUnknown);

  const SE2 T_est_ref = T_ref_est.inverse();
  for (int row = 0; row < map.height; ++row)
    for (int column = 0; column < map.width; ++column) {
      const Eigen::Vector2d p =
          T_est_ref * Eigen::Vector2d(reference.origin_x_m + (low.x() + column + 0.5) * step,
                                      reference.origin_y_m + (low.y() + row + 0.5) * step);
      const CellState state = reference_at(
          estimate, int(std::floor((p.x() - estimate.origin_x_m) / estimate.resolution_m)),
          int(std::floor((p.y() - estimate.origin_y_m) / estimate.resolution_m)));
      if (state == CellState::kUnoccupied)
        map.cells[std::size_t(row) * std::size_t(map.width) + std::size_t(column)] = state;
    }
  for (int row = 0; row < estimate.height; ++row)
    for (int column = 0; column < estimate.width; ++column) {
      if (reference_at(estimate, column, row) != CellState::kOccupied) continue;
      for (int i = 0; i < parts * parts; ++i) {
        const int part_x = i % parts;
        const int part_y = i / parts;
        const Eigen::Vector2i cell =
            cell_of(in_reference(column + (part_x + 0.5) / parts, row + (part_y + 0.5) / parts));
        map.cells[std::size_t(cell.y() - low.y()) * std::size_t(map.width) +
                  std::size_t(cell.x() - low.x())] = CellState::kOccupied;
      }
    }
  return Outcome<ResampledMap>::success(std::move(map));
}

double MapScore::precision() const { return ratio(estimate_right, estimate_occupied); }
double MapScore::f1() const {
  const double sum = precision() + recall();
  return sum == 0.0 ? 0.0 : 2.0 * precision() * recall() / sum;
}
double MapScore::iou() const {
  return ratio(occupied.found, occupied.cells + estimate_occupied - estimate_right);
}
double MapScore::free_accuracy() const { return ratio(free_right, free_right + free_wrong); }
double MapScore::free_coverage() const { return ratio(free_right + free_wrong, reference_free); }

MapScore score_map(const MapRaster& reference, const std::vector<std::uint8_t>& classes,
                   const ResampledMap& estimate, int tolerance_cells) {
  const auto is_reference = [&](int column, int row) {
    return reference_at(reference, column, row) == CellState::kOccupied;
  };
  const auto is_estimate = [&](int column, int row) {
    return estimate.at(column, row) == CellState::kOccupied;
  };
  const Dilated near_reference(0, 0, reference.width, reference.height, tolerance_cells,
                               is_reference);
  const Dilated near_estimate(estimate.first_column, estimate.first_row, estimate.width,
                              estimate.height, tolerance_cells, is_estimate);
  MapScore score;
  for (int row = 0; row < estimate.height; ++row)
    for (int column = 0; column < estimate.width; ++column) {
      const int c = estimate.first_column + column, r = estimate.first_row + row;
      if (!is_estimate(c, r)) continue;
      ++score.estimate_occupied;
      if (near_reference.at(c, r))
        ++score.estimate_right;
      else if (reference_at(reference, c, r) == CellState::kUnoccupied)
        ++score.false_in_free;
      else
        ++score.false_in_unknown;
    }
  for (int row = 0; row < reference.height; ++row)
    for (int column = 0; column < reference.width; ++column) {
      const CellState truth = reference_at(reference, column, row);
      const CellState said = estimate.at(column, row);
      if (truth == CellState::kOccupied) {
        const std::size_t kind = classes.empty() ? 0 : classes[reference.index(column, row)];
        for (ClassScore* s :
             {&score.occupied, &score.by_class[std::min(kind, kObstacleClasses - 1)]}) {
          ++s->cells;
          if (near_estimate.at(column, row))
            ++s->found;
          else if (said == CellState::kUnoccupied)
            ++s->called_free;
        }
      } else if (truth == CellState::kUnoccupied) {
        if (said == CellState::kOccupied && near_reference.at(column, row)) {
          ++score.free_excused;
          continue;
        }
        ++score.reference_free;
        if (said == CellState::kUnoccupied) ++score.free_right;
        if (said == CellState::kOccupied) ++score.free_wrong;
      }
    }
  return score;
}

}  // namespace fusion_slam
