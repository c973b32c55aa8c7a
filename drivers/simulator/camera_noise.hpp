// What a structured-light RGB-D camera makes of the ideal image.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/simulator/camera_renderer.hpp"
#include "libs/camera/rgbd_frame.hpp"

namespace fusion_slam {

struct CameraNoise {
  double baseline_m = 0.075;             // projector to infra-red camera, Orbbec Astra
  double disparity_step_px = 0.125;      // its matcher interpolates to eighths of a pixel
  double depth_sigma_at_0_4_m = 0.0012;  // Nguyen, Izadi & Lovell 2012:
  double depth_sigma_per_m = 0.0019;     // sigma(z) = 0.0012 + 0.0019 (z - 0.4)^2
  double edge_drop_fraction = 0.7;       // depth pixels lost on depth edges: the projector's shadow
  double edge_jump = 0.03;               // a jump of this fraction of the depth is an edge
  double grazing_cosine = 0.12;          // flatter than this the pattern does not come back
  double colour_sigma = 2.5;             // grey values
  double exposure = 1.05;                // constant: automatic exposure off
};

class NoisyCamera {
 public:
  // Everything random follows from the seed and the frame's index.
  NoisyCamera(CameraModel camera, CameraNoise noise, std::uint64_t seed);
  // With noise false: exposure, range limits and millimetres only.
  RgbdFrame expose(const RenderedFrame& ideal, std::int64_t index, std::int64_t utime_us,
                   bool noise) const;

 private:
  double measured_depth(double z_m, double gaussian) const;

  CameraModel camera_;
  CameraNoise noise_;
  std::uint64_t seed_;
  std::vector<float> gaussians_;  // a large sample to draw from: an image takes over a million
};

}  // namespace fusion_slam
