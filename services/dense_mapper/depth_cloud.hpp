// Keyframe depth to a filtered, coloured cloud in the camera frame: equations 1 and 2 of the paper,
// without the pixels that lie: outside the trusted range, beside holes, and on the edges where the
// sensor mixes foreground and background.
#pragma once

#include <cstdint>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/camera/rgbd_frame.hpp"
#include "libs/cloud/cloud_tile.hpp"
#include "services/dense_mapper/config.hpp"

namespace fusion_slam {

// A point with its surface normal, for finding the floor. Camera frame or submap frame, as the
// holder says.
struct SurfacePoint {
  Eigen::Vector3f p_m = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, towards the camera
};

struct DepthCloud {
  std::int64_t utime_us = 0;
  std::vector<ColouredPoint> points;   // camera frame, one a sampled pixel, row by row
  std::vector<std::uint32_t> sparse;   // of them, those for the cloud: every second of both axes
  std::vector<SurfacePoint> surfaces;  // camera frame, far fewer
};

// How far depth is trusted: the camera's own limit, and where its sigma is no larger than a voxel.
double trusted_depth_m(const CameraModel& camera, double resolution_m);

DepthCloud make_depth_cloud(const RgbdFrame& frame, const CameraModel& camera, double resolution_m,
                            const DenseMapperConfig& config);

}  // namespace fusion_slam
