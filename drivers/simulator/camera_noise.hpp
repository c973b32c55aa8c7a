// What a structured-light RGB-D camera of the Orbbec Astra Mini's class makes of the ideal image.
// Every effect can be left out by itself; sensor_noise.hpp has their names.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/simulator/camera_renderer.hpp"
#include "drivers/simulator/image_motion.hpp"
#include "libs/camera/rgbd_frame.hpp"

namespace fusion_slam {

struct CameraNoise {
  // Colour.
  double colour_sigma = 2.5;  // grey values at mid-grey (128): a small sensor by indoor light
  double photon_share = 0.6;  // of that variance grows with the light: EMVA 1288, sigma^2 = a + b I
  double exposure = 1.05;     // factor on the ideal image while automatic exposure is off
  double exposure_target = 112.0;  // automatic exposure steers the mean grey value here ...
  double exposure_time_constant_s =
      0.4;                    // ... with this lag (UVC cameras settle in 0.5 to 1 s) ...
  double exposure_min = 0.6;  // ... between these factors
  double exposure_max = 1.8;
  double shutter_s = 0.008;          // open so long (at factor 1): indoor, lights at 100 Hz
  double rolling_readout_s = 0.025;  // first to last row, when rolling-shutter is on
  // Depth.
  double baseline_m = 0.075;             // projector to infra-red camera, Orbbec Astra
  double disparity_step_px = 0.125;      // its matcher interpolates to eighths of a pixel
  double depth_sigma_at_0_4_m = 0.0012;  // Nguyen, Izadi & Lovell 2012 (axial, Kinect v1):
  double depth_sigma_per_m = 0.0019;     // sigma(z) = 0.0012 + 0.0019 (z - 0.4)^2
  double correlated_share = 0.5;         // of that variance is common to neighbours: a matcher's
  int correlation_px = 5;                // window is about 9 px (Konolige & Mihelich 2011)
  double edge_drop_fraction = 0.7;       // depth pixels lost on depth edges
  double edge_jump = 0.03;               // a jump of this fraction of the depth is an edge
  double grazing_cosine = 0.12;          // flatter than this the pattern does not come back
  double dark_signal = 0.15;  // least (grey / 255) cos (depth_max / z)^2: radar equation, Lambert
  double depth_delay_s = 0.004;  // depth is taken so much later than colour: not synchronised
  // Effects.
  bool with_colour_noise = true;
  bool with_photon_noise = true;
  bool with_exposure = true;
  bool with_motion_blur = true;
  bool with_rolling_shutter = false;
  bool with_depth_noise = true;
  bool with_depth_correlation = true;
  bool with_depth_steps = true;
  bool with_depth_edges = true;
  bool with_depth_shadow = true;
  bool with_depth_dropouts = true;
  bool with_depth_delay = true;
};

// One frame's circumstances.
struct Shot {
  std::int64_t index = 0;  // of the frame: what is random follows from it and the seed
  std::int64_t utime_us = 0;
  double exposure = 1.0;  // factor on the ideal image
  CameraTwist twist;      // how the camera moves
};

// const members are thread-safe.
class NoisyCamera {
 public:
  NoisyCamera(CameraModel camera, CameraNoise noise, std::uint64_t seed);

  // Blur, rolling shutter, exposure, noise; depth seen depth_delay_s later, shadows of the
  // projector, lost pixels, noise, steps of disparity, range limits, millimetres.
  RgbdFrame expose(const RenderedFrame& ideal, const Shot& shot) const;
  // What comes of a covered lens: dark noise, no depth.
  RgbdFrame dark(const Shot& shot) const;

  const CameraNoise& noise() const { return noise_; }

 private:
  void colour_row(const cv::Mat_<cv::Vec3f>& light, int v, const Shot& shot, cv::Mat* out) const;
  void depth_row(const RenderedFrame& ideal, const cv::Mat_<float>& depth, int v, const Shot& shot,
                 const std::vector<float>& patches, cv::Mat* out) const;
  std::vector<float> patch_noise(std::int64_t index) const;

  CameraModel camera_;
  CameraNoise noise_;
  std::uint64_t seed_;
  std::vector<float> gaussians_;  // a large sample to draw from: an image takes over a million
};

// Mean of blue, green and red over every 8th pixel: what automatic exposure meters.
double mean_grey(const RenderedFrame& frame);

}  // namespace fusion_slam
