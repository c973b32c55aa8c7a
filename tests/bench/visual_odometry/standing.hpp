// What a camera sees that stands still: one frame with ever new noise.
#pragma once

#include <functional>

#include "libs/camera/camera_model.hpp"
#include "libs/camera/rgbd_frame.hpp"

namespace fusion_slam {

// Plays `frame` again for `minutes` of stamps, `hz` frames a second, each with its own seeded
// noise: 2.5 of 255 in colour, the camera model's sigma in depth. After each whole minute `minute`
// is told its number.
void stand_still(const RgbdFrame& frame, const CameraModel& camera, double minutes, double hz,
                 const std::function<void(const RgbdFrame&)>& show,
                 const std::function<void(int minute)>& minute);

// Resident memory of this process now, MB. 0 where /proc is missing.
double resident_mb();

}  // namespace fusion_slam
