#include "libs/features/feature_grid.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr double kCell_px = 16.0;  // about the usual search radius

}  // namespace

FeatureGrid::FeatureGrid(const std::vector<Feature>& features, int width_px, int height_px)
    : features_(&features),
      columns_(static_cast<int>(width_px / kCell_px) + 1),
      rows_(static_cast<int>(height_px / kCell_px) + 1),
      cells_(static_cast<std::size_t>(columns_) * rows_) {
  for (std::size_t i = 0; i < features.size(); ++i)
    cells_[cell(features[i].v_px, rows_) * columns_ + cell(features[i].u_px, columns_)].push_back(
        static_cast<int>(i));
}

int FeatureGrid::cell(double px, int cells) const {
  return static_cast<int>(std::clamp(std::floor(px / kCell_px), 0.0, cells - 1.0));
}

void FeatureGrid::near(double u_px, double v_px, double radius_px, int octave_min, int octave_max,
                       std::vector<int>* indices) const {
  indices->clear();
  const double radius2 = radius_px * radius_px;
  for (int y = cell(v_px - radius_px, rows_); y <= cell(v_px + radius_px, rows_); ++y)
    for (int x = cell(u_px - radius_px, columns_); x <= cell(u_px + radius_px, columns_); ++x)
      for (const int i : cells_[y * columns_ + x]) {
        const Feature& f = (*features_)[i];
        if (f.octave < octave_min || f.octave > octave_max) continue;
        const double du = f.u_px - u_px;
        const double dv = f.v_px - v_px;
        if (du * du + dv * dv <= radius2) indices->push_back(i);
      }
}

}  // namespace fusion_slam
