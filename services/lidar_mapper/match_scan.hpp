// Places a scan in a submap: correlative search around the prediction, least squares, and a
// verdict. Pure functions.
#pragma once

#include "libs/scan_matching/overlap.hpp"
#include "libs/scan_matching/search_pyramid.hpp"
#include "services/lidar_mapper/config.hpp"
#include "services/lidar_mapper/motion_predictor.hpp"
#include "services/lidar_mapper/submap.hpp"

namespace fusion_slam {

enum class MatchState { kOk, kWeak, kLost };

struct ScanMatch {
  SE2 T_odom_base;  // the prediction when kLost
  Twist twist;      // during the sweep
  // What the scan alone says of the pose, (x, y, yaw) in base axes; 0 when kLost.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  MatchState state = MatchState::kLost;
  const char* reason = "";  // why the state is not kOk
  Overlap overlap;
};

// `pyramid` is that of the submap's raster; `covariance` that of the predicted pose in the submap,
// (x, y, yaw) in base axes: uncertainty since long ago included.
ScanMatch match_scan(const Submap& submap, const SearchPyramid& pyramid, const ScanPoints& points,
                     const SE2& T_odom_predicted, const Prediction& prediction,
                     const Eigen::Matrix3d& covariance, const RobotModel& robot,
                     const LidarMapperConfig& config);

// What is left when matching can't be done: kLost at the prediction.
ScanMatch dead_reckon(const SE2& T_odom_predicted, const Prediction& prediction,
                      const char* reason);

}  // namespace fusion_slam
