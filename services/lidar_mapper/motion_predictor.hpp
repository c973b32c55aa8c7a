// Where the robot should be at the next scan: from wheel odometry, else visual odometry, else the
// velocity of the last scans. Deterministic; one thread.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "libs/geometry/pose.hpp"
#include "libs/scan_matching/twist.hpp"
#include "services/lidar_mapper/config.hpp"
#include "services/lidar_mapper/scan_clock.hpp"

namespace fusion_slam {

// Poses of another sensor in its own drifting frame, by time. Only differences of them mean
// anything.
class MotionSource {
 public:
  void add(std::int64_t utime_us, const SE2& T_odom_base);
  void clear() { poses_.clear(); }
  bool empty() const { return poses_.empty(); }
  std::int64_t newest_us() const { return poses_.empty() ? 0 : poses_.back().utime_us; }

  // T_base(from)_base(to); nothing when the poses don't reach both times (extrapolating at most
  // max_extrapolation_s).
  std::optional<SE2> motion(std::int64_t from_us, std::int64_t to_us,
                            double max_extrapolation_s) const;

 private:
  struct Stamped {
    std::int64_t utime_us;
    SE2 pose;
  };
  bool silent_between(std::int64_t from_us, std::int64_t to_us) const;
  std::optional<SE2> pose_at(std::int64_t utime_us, double max_extrapolation_s) const;
  std::deque<Stamped> poses_;
};

enum class PredictionSource { kNone, kOdometry, kVisual, kConstantVelocity };

struct Prediction {
  SE2 motion;            // T_base(last scan)_base(this scan)
  Twist twist;           // velocity that goes on during this scan
  double sigma_m = 0.0;  // of the motion, each axis
  double sigma_rad = 0.0;
  // The truth is within this: never less than three of the configuration's sigmas, however well the
  // source has done so far.
  double window_m = 0.0;
  double window_rad = 0.0;
  Eigen::Vector3d twist_sigma = Eigen::Vector3d::Zero();  // m/s, m/s, rad/s
  // Of (x, y, yaw) in base axes at the end of the motion.
  Eigen::Matrix3d covariance() const;
  PredictionSource source = PredictionSource::kNone;
  // The robot may be further away than the widest search reaches: a match there would prove
  // nothing.
  bool blind = false;
};

class MotionPredictor {
 public:
  explicit MotionPredictor(const LidarMapperConfig& config) : config_(config) {}

  void add_odometry(std::int64_t utime_us, const SE2& T_odom_base) {
    odometry_.add(utime_us, T_odom_base);
  }
  void add_visual(std::int64_t utime_us, const SE2& T_odom_base) {
    visual_.add(utime_us, T_odom_base);
  }
  void visual_lost() { visual_.clear(); }  // its frame may have jumped

  // `interval` since the last scan, which was at last_us.
  Prediction predict(std::int64_t last_us, std::int64_t now_us, const ScanClock::Interval& interval,
                     double resolution_m) const;

  // The pose that the matching found, dt_s after the one before.
  void add_scan_pose(double dt_s, const SE2& T_odom_base);
  // The same, with the velocity that was found during the sweep.
  void add_scan_pose(double dt_s, const SE2& T_odom_base, const Twist& twist);
  void forget_velocity() { history_.clear(); }
  Twist velocity() const;  // of the last scans; 0 when unknown

  // What a good match says of the prediction: `error` of it, (x, y, yaw) in base axes, where
  // `explained` of variance was expected by the prediction and seen by the match (0 in directions
  // that the match didn't see). The source's sigmas grow or shrink with it.
  void learn(PredictionSource source, const Eigen::Vector3d& error,
             const Eigen::Vector3d& explained);
  // Sigmas of this source, in those that the configuration starts with: (translation, rotation).
  Eigen::Vector2d trust(PredictionSource source) const;

 private:
  const LidarMapperConfig config_;
  MotionSource odometry_;
  MotionSource visual_;
  struct Past {
    double dt_s;  // since the entry before
    SE2 pose;
    std::optional<Twist> twist;
  };
  std::deque<Past> history_;
  // Variances of the sources in those of the configuration: (translation, rotation), by source.
  Eigen::Vector2d learned_[4] = {Eigen::Vector2d::Ones(), Eigen::Vector2d::Ones(),
                                 Eigen::Vector2d::Ones(), Eigen::Vector2d::Ones()};
};

}  // namespace fusion_slam
