// A box face as a picture: its texture times the light that falls on it. Nothing moves, so light
// and shadows are computed once.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "drivers/simulator/lighting.hpp"
#include "drivers/simulator/mip_map.hpp"
#include "drivers/simulator/scene.hpp"

namespace fusion_slam {

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
  const MipMap& picture() const { return *picture_; }
  float texels_per_m_s() const { return texels_per_m_s_; }
  float texels_per_m_t() const { return texels_per_m_t_; }

 private:
  float texels_per_m_s_ = 1.0F;  // of the full resolution
  float texels_per_m_t_ = 1.0F;
  std::unique_ptr<const MipMap> picture_;
};

}  // namespace fusion_slam
