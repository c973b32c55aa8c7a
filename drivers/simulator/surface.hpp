// A box face as a picture: its texture times the light that falls on it, at several resolutions
// (mip map, Williams 1983). Nothing moves, so light and shadows are computed once.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/simulator/scene.hpp"

namespace fusion_slam {

struct Lighting {
  std::vector<Eigen::Vector3d> lamps_m;  // world; seen through by nothing but boxes
  double ambient = 0.50;                 // light from everywhere: walls scatter most of it
  double lamp_power = 1.7;
};

// Axes of a face's picture in the box's frame: s to the right and t down as seen from outside, so
// that text reads. Lengths in metres.
struct FaceAxes {
  Eigen::Vector3d corner;  // upper left
  Eigen::Vector3d s;
  Eigen::Vector3d t;
  double width_m = 0.0;
  double height_m = 0.0;
};
FaceAxes face_axes(const Box& box, int face);

// const and thread-safe after construction.
class Surface {
 public:
  Surface(const Scene& scene, const Lighting& lighting, int box, int face);
  // Blue, green, red, 0 to 255, at (s, t) metres seen by pixels that cover footprint_m of it.
  std::array<float, 3> at(float s_m, float t_m, float footprint_m) const;

 private:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<std::array<std::uint8_t, 4>> texels;
  };
  static Level half_size(const Level& level);
  void add_bilinear(std::size_t level, float s_m, float t_m, float weight, float* bgr) const;

  float texels_per_m_s_ = 1.0F;  // of level 0
  float texels_per_m_t_ = 1.0F;
  std::vector<Level> levels_;
};

}  // namespace fusion_slam
