// How the camera looks at the floor: its height, roll and pitch. All frames of a drive together; a
// plane is a linear function of the ray in inverse depth, where the camera's noise is even, so that
// far floor is neither trusted too much nor bent. Pure, deterministic.
#pragma once

#include <optional>
#include <vector>

#include "libs/calibration/drive.hpp"

namespace fusion_slam {

// Of the camera's mounting: R_base_camera = Rz(yaw) * level, level = Ry(pitch) * Rx(roll) *
// optical_to_body().
struct FloorView {
  double height_m = 0.0;
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();  // of the three, m, rad, rad
  int n_frames = 0;                                 // in which a floor was seen

  // Takes points of the camera frame to the level frame: origin on the floor below the camera, z
  // up.
  SE3 T_level_camera() const;
};

// The mounting as three numbers.
FloorView floor_view_of(const SE3& T_base_camera);

// Looks within 15 degrees and 0.2 m of the mounting on paper. Nothing when fewer than 20 frames
// show a floor.
std::optional<FloorView> find_floor(const std::vector<DepthFrame>& frames,
                                    const CameraModel& camera, const SE3& T_base_camera);

// Which block of the jackknife a time belongs to.
std::int64_t block_of(std::int64_t utime_us);
std::int64_t block_begin_us(std::int64_t block);

}  // namespace fusion_slam
