#include "services/lidar_mapper/motion_predictor.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr std::size_t kRememberedPoses = 512;       // seconds of any odometry
constexpr std::int64_t kRememberedUs = 60'000'000;  // and as long: scans may fail for a while
constexpr std::int64_t kLongestGapUs = 1'000'000;
constexpr std::int64_t kBackwardsUs = 1'000'000;  // further back than this is a new recording
constexpr int kVelocityIntervals =
    2;  // one interval carries the jitter of its stamps and matches in full
constexpr double kVelocitySpanS = 0.12;

constexpr double kWindowSigmas = 3.0;
constexpr double kBlindSigmas = 2.0;    // that the widest search must cover: 3 s without any sensor
constexpr double kContradiction = 0.5;  // of the distance between two predictions: a sigma
constexpr double kLearningRate = 0.04;  // a few seconds
constexpr double kSmallestVariance =
    0.25;  // of the configuration's: half its sigma; wheels slip at last
constexpr double kGreatestVariance = 9.0;

double clamp_abs(double value, double limit) { return std::clamp(value, -limit, limit); }

}  // namespace

void MotionSource::add(std::int64_t utime_us, const SE2& T_odom_base) {
  if (!poses_.empty()) {
    const std::int64_t ahead = utime_us - poses_.back().utime_us;
    if (ahead < -kBackwardsUs)
      poses_.clear();
    else if (ahead <= 0)
      return;  // repeated or late: the newer one knows better
  }
  poses_.push_back({utime_us, T_odom_base});
  while (poses_.size() > kRememberedPoses && utime_us - poses_.front().utime_us > kRememberedUs)
    poses_.pop_front();
}

std::optional<SE2> MotionSource::pose_at(std::int64_t utime_us, double max_extrapolation_s) const {
  if (poses_.empty() || utime_us < poses_.front().utime_us) return std::nullopt;
  const auto after =
      std::lower_bound(poses_.begin(), poses_.end(), utime_us,
                       [](const Stamped& s, std::int64_t t) { return s.utime_us < t; });
  if (after != poses_.end() && after->utime_us == utime_us) return after->pose;
  const bool ahead = after == poses_.end();
  if (ahead && poses_.size() < 2) return std::nullopt;
  const Stamped& b = ahead ? poses_.back() : *after;
  const Stamped& a = ahead ? poses_[poses_.size() - 2] : *(after - 1);
  if (b.utime_us - a.utime_us > kLongestGapUs) return std::nullopt;
  if (static_cast<double>(utime_us - b.utime_us) * 1e-6 > max_extrapolation_s) return std::nullopt;
  const double span_s = static_cast<double>(b.utime_us - a.utime_us) * 1e-6;
  const Twist twist = Twist::from_motion(a.pose.inverse() * b.pose, span_s);
  return a.pose * twist.motion(static_cast<double>(utime_us - a.utime_us) * 1e-6);
}

// Then the source may have begun anew, in a frame of its own.
bool MotionSource::silent_between(std::int64_t from_us, std::int64_t to_us) const {
  auto it = std::upper_bound(poses_.begin(), poses_.end(), from_us,
                             [](std::int64_t t, const Stamped& s) { return t < s.utime_us; });
  for (; it != poses_.end() && it->utime_us <= to_us; ++it)
    if (it != poses_.begin() && it->utime_us - (it - 1)->utime_us > kLongestGapUs) return true;
  return false;
}

std::optional<SE2> MotionSource::motion(std::int64_t from_us, std::int64_t to_us,
                                        double max_extrapolation_s) const {
  const auto from = pose_at(from_us, max_extrapolation_s);
  const auto to = pose_at(to_us, max_extrapolation_s);
  if (!from || !to || silent_between(from_us, to_us)) return std::nullopt;
  return from->inverse() * *to;
}

Twist MotionPredictor::velocity() const {
  double span_s = 0.0;
  int intervals = 0;
  std::size_t i = history_.size();
  while (i > 1 && (intervals < kVelocityIntervals || span_s < kVelocitySpanS)) {
    span_s += history_[--i].dt_s;
    ++intervals;
  }
  if (!history_.empty() && history_.back().twist) {
    Twist t = *history_.back().twist;
    t.vx_mps = clamp_abs(t.vx_mps, config_.max_speed_mps);
    t.vy_mps = clamp_abs(t.vy_mps, config_.max_speed_mps);
    t.turn_radps = clamp_abs(t.turn_radps, config_.max_turn_radps);
    return t;
  }
  if (intervals == 0) return {};
  Twist twist = Twist::from_motion(history_[i - 1].pose.inverse() * history_.back().pose, span_s);
  twist.vx_mps = clamp_abs(twist.vx_mps, config_.max_speed_mps);
  twist.vy_mps = clamp_abs(twist.vy_mps, config_.max_speed_mps);
  twist.turn_radps = clamp_abs(twist.turn_radps, config_.max_turn_radps);
  return twist;
}

Prediction MotionPredictor::predict(std::int64_t last_us, std::int64_t now_us,
                                    const ScanClock::Interval& interval,
                                    double resolution_m) const {
  const double dt = interval.dt_s;
  Prediction p;
  auto measured = odometry_.motion(last_us, now_us, config_.max_extrapolation_s);
  p.source = PredictionSource::kOdometry;
  if (!measured) {
    measured = visual_.motion(last_us, now_us, config_.max_extrapolation_s);
    p.source = PredictionSource::kVisual;
  }
  const bool plausible = measured && interval.trusted &&
                         std::hypot(measured->x, measured->y) <= config_.max_speed_mps * dt &&
                         std::abs(measured->yaw) <= config_.max_turn_radps * dt;
  if (plausible) {
    p.motion = *measured;
    p.twist = Twist::from_motion(*measured, dt);
    p.sigma_m =
        config_.odometry_sigma_m + config_.odometry_error * std::hypot(measured->x, measured->y);
    p.sigma_rad = config_.odometry_sigma_rad + config_.odometry_error * std::abs(measured->yaw);
  } else {
    p.source = PredictionSource::kConstantVelocity;
    p.twist = velocity();
    // Over a gap the robot may have done anything: don't carry the velocity far.
    p.motion = p.twist.motion(std::min(dt, 0.5));
    p.sigma_m = std::max(config_.speed_change_mps * dt, resolution_m);
    p.sigma_rad = std::max(config_.turn_change_radps * dt, 0.03);
  }
  p.blind = kBlindSigmas * p.sigma_m > config_.max_window_m;
  const Eigen::Vector2d scale = trust(p.source);
  p.window_m = kWindowSigmas * p.sigma_m * std::max(1.0, scale.x());
  p.window_rad = kWindowSigmas * p.sigma_rad * std::max(1.0, scale.y());
  p.sigma_m *= scale.x();
  p.sigma_rad *= scale.y();
  if (plausible && history_.size() > 2) {
    // Odometry that stalls for half a second and then jumps says "standing" of a robot that drives.
    // Where it contradicts the last velocity, the window reaches from one to the other, and the
    // scan decides.
    const SE2 going_on = velocity().motion(std::min(dt, 0.5));
    const double apart_m = std::hypot(measured->x - going_on.x, measured->y - going_on.y);
    const double apart_rad = std::abs(wrap_angle(measured->yaw - going_on.yaw));
    p.sigma_m = std::hypot(p.sigma_m, kContradiction * apart_m);
    p.sigma_rad = std::hypot(p.sigma_rad, kContradiction * apart_rad);
    p.window_m = std::max(p.window_m, apart_m + resolution_m);
    p.window_rad = std::max(p.window_rad, 1.2 * apart_rad);
  }
  p.twist_sigma << config_.speed_change_mps, config_.speed_change_mps, config_.turn_change_radps;
  p.twist_sigma *= scale.y();
  return p;
}

Eigen::Matrix3d Prediction::covariance() const {
  return Eigen::Vector3d(sigma_m, sigma_m, sigma_rad).array().square().matrix().asDiagonal();
}

Eigen::Vector2d MotionPredictor::trust(PredictionSource source) const {
  return learned_[static_cast<std::size_t>(source)].cwiseSqrt();
}

void MotionPredictor::learn(PredictionSource source, const Eigen::Vector3d& error,
                            const Eigen::Vector3d& explained) {
  Eigen::Vector2d& learned = learned_[static_cast<std::size_t>(source)];
  const auto follow = [](double& variance, double squared, double expected) {
    if (!(expected > 0.0)) return;
    const double ratio = std::min(squared / expected, 9.0);  // a slip is not the rule
    variance = std::clamp(variance * (1.0 + kLearningRate * (ratio - 1.0)), kSmallestVariance,
                          kGreatestVariance);
  };
  follow(learned.x(), error.head<2>().squaredNorm(), explained.head<2>().sum());
  follow(learned.y(), error.z() * error.z(), explained.z());
}

void MotionPredictor::add_scan_pose(double dt_s, const SE2& T_odom_base) {
  history_.push_back({dt_s, T_odom_base, std::nullopt});
  if (history_.size() > 32) history_.pop_front();
}

void MotionPredictor::add_scan_pose(double dt_s, const SE2& T_odom_base, const Twist& twist) {
  add_scan_pose(dt_s, T_odom_base);
  history_.back().twist = twist;
}

}  // namespace fusion_slam
