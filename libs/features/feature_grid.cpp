#include "libs/features/feature_grid.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr double kCell_px = 16.0;  // about the usual search radius

}  // namespace

FeatureGrid::FeatureGrid(const std::vector<Feature>& features, int width_px, int height_px)
    : columns_(static_cast<int>(width_px / kCell_px) + 1),
      rows_(static_cast<int>(height_px / kCell_px) + 1),
      begins_(static_cast<std::size_t>(columns_) * rows_ + 1, 0),
      entries_(features.size()) {
  std::vector<int> cell_of(features.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    cell_of[i] = cell(features[i].v_px, rows_) * columns_ + cell(features[i].u_px, columns_);
    ++begins_[cell_of[i] + 1];
  }
  for (std::size_t c = 1; c < begins_.size(); ++c) begins_[c] += begins_[c - 1];
  std::vector<int> next(begins_.begin(), begins_.end() - 1);
  for (std::size_t i = 0; i < features.size(); ++i) {
    const Feature& f = features[i];
    entries_[next[cell_of[i]]++] = {f.u_px, f.v_px, static_cast<int>(i), f.octave};
  }
}

int FeatureGrid::cell(double px, int cells) {
  return static_cast<int>(std::clamp(std::floor(px / kCell_px), 0.0, cells - 1.0));
}

void FeatureGrid::near(double u_px, double v_px, double radius_px, int octave_min, int octave_max,
                       std::vector<int>* indices) const {
  indices->clear();
  const double radius2 = radius_px * radius_px;
  const int x0 = cell(u_px - radius_px, columns_);
  const int x1 = cell(u_px + radius_px, columns_);
  const int y0 = cell(v_px - radius_px, rows_);
  const int y1 = cell(v_px + radius_px, rows_);
  for (int y = y0; y <= y1; ++y) {
    const Entry* end = entries_.data() + begins_[y * columns_ + x1 + 1];
    for (const Entry* e = entries_.data() + begins_[y * columns_ + x0]; e != end; ++e) {
      if (e->octave < octave_min || e->octave > octave_max) continue;
      const double du = e->u_px - u_px;
      const double dv = e->v_px - v_px;
      if (du * du + dv * dv <= radius2) indices->push_back(e->index);
    }
  }
}

}  // namespace fusion_slam
