// Finds the features near a pixel without looking at all of them.
#pragma once

#include <vector>

#include "libs/features/feature.hpp"

namespace fusion_slam {

class FeatureGrid {
 public:
  // Keeps indices into `features`; positions may lie outside the image (undistorted corners).
  FeatureGrid(const std::vector<Feature>& features, int width_px, int height_px);

  // Indices, ascending within a cell, of the features within radius_px (Euclidean) of (u, v) and
  // with octave_min <= octave <= octave_max.
  void near(double u_px, double v_px, double radius_px, int octave_min, int octave_max,
            std::vector<int>* indices) const;

 private:
  // What near() looks at, cell by cell, side by side in memory.
  struct Entry {
    float u_px;
    float v_px;
    int index;
    int octave;
  };
  static int cell(double px, int cells);

  int columns_;
  int rows_;
  std::vector<int> begins_;  // of each cell's entries; one more at the end
  std::vector<Entry> entries_;
};

}  // namespace fusion_slam
