// LIDAR_POSE without a bus: the LiDAR mapper beside visual odometry, as in the whole system.
#pragma once

#include <functional>
#include <optional>

#include "services/lidar_mapper/lidar_mapper.hpp"
#include "services/visual_odometry/tracking_result.hpp"

namespace fusion_slam {

class LidarPredictor {
 public:
  explicit LidarPredictor(const RobotModel& robot) : mapper_(robot) {}

  void add_odometry(std::int64_t utime_us, const SE3& T_odom_base) {
    mapper_.add_odometry(utime_us, to_se2(T_odom_base));
  }
  void add_visual(const TrackingResult& result) {
    mapper_.add_visual_pose(result.utime_us, to_se2(result.T_odom_base),
                            result.state == TrackingState::kOk);
  }
  // Tells `said` the pose of the scan, when it has one.
  void add_scan(const LaserScan& scan,
                const std::function<void(std::int64_t utime_us, const SE3& T_odom_base)>& said) {
    const MapperOutput output = mapper_.add_scan(scan);
    if (output.pose && output.pose->state != MatchState::kLost)
      said(output.pose->utime_us, to_se3(output.pose->T_odom_base));
  }

 private:
  LidarMapper mapper_;
};

}  // namespace fusion_slam
