// A camera carried by a walking person along a robot's way: height, pitch, roll, yaw and place sway
// smoothly about the path.
#pragma once

#include <array>
#include <cstdint>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

struct HandHeld {
  double height_m = 1.30;   // of the camera, mean
  double pitch_rad = 0.17;  // looks 10 degrees down, mean
  // Greatest offsets from the mean; reached seldom, since several waves add up to them.
  double sway_height_m = 0.10;
  double sway_aside_m = 0.08;
  double sway_ahead_m = 0.05;
  double sway_yaw_rad = 0.30;
  double sway_pitch_rad = 0.14;
  double sway_roll_rad = 0.09;
};

// Each axis is the sum of three sine waves with seeded phases and frequencies: looking about (0.05
// to 0.2 Hz), unsteady hands (0.3 to 0.8 Hz) and steps (1.6 to 2.2 Hz; Zijlstra & Hof 2003:
// walking). const members are thread-safe.
class HandHeldSway {
 public:
  HandHeldSway(const HandHeld& carried, std::uint64_t seed);
  // T_path_base: base is the camera in body axes (x forward, z up), path the point on the floor
  // where a robot would be.
  SE3 T_path_base(double time_s) const;

 private:
  struct Wave {
    double share, rad_s, phase_rad;
  };
  double wave(std::size_t axis, double time_s) const;  // -1 to 1
  HandHeld carried_;
  std::array<std::array<Wave, 3>, 6> waves_{};
};

}  // namespace fusion_slam
