#include "services/visual_odometry/visual_odometry.hpp"

#include <algorithm>

#include <opencv2/imgproc.hpp>

#include "libs/features/feature_depth.hpp"
#include "services/visual_odometry/correspondences.hpp"
#include "services/visual_odometry/relocaliser.hpp"

namespace fusion_slam {
namespace {

double median_depth(const FeatureSet& set) {
  std::vector<float> depths;
  for (const Feature& f : set.features)
    if (f.depth_m > 0.0F) depths.push_back(f.depth_m);
  if (depths.empty()) return 0.0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

int with_depth(const FeatureSet& set) {
  return static_cast<int>(std::count_if(set.features.begin(), set.features.end(),
                                        [](const Feature& f) { return f.depth_m > 0.0F; }));
}

}  // namespace

VisualOdometry::VisualOdometry(const CameraModel& camera, const SE3& T_base_camera,
                               const VisualOdometryConfig& config)
    : config_(config),
      camera_(camera),
      T_base_camera_(T_base_camera),
      extractor_(config.orb),
      T_odom_camera_(T_base_camera),
      T_odom_keyframe_(T_base_camera) {
  for (int i = 0; i < config.orb.n_levels; ++i) scales_.push_back(extractor_.scale(i));
}

TrackingResult VisualOdometry::track(const RgbdFrame& frame) {
  TrackingResult refused;
  refused.utime_us = frame.utime_us;
  refused.reason = refuse(frame);
  if (!refused.reason.empty()) {
    fill_pose(T_odom_camera_, &refused);
    return refused;
  }
  last_utime_us_ = frame.utime_us;
  FeatureSet set = see(frame);
  if (!segment_started_) return lost(frame.utime_us, std::move(set));

  std::optional<Estimate> estimate =
      track_map(motion_.predict(frame.utime_us), set, config_.wide_radius_px);
  if (!estimate) estimate = track_map(T_odom_camera_, set, 2.0 * config_.wide_radius_px);
  if (!estimate)
    if (const auto pose = relocalise(map_, camera_, set, scales_, config_))
      estimate = track_map(*pose, set, config_.narrow_radius_px);
  if (!estimate) return lost(frame.utime_us, std::move(set));
  return tracked(frame.utime_us, *estimate, std::move(set));
}

void VisualOdometry::reset() {
  map_.clear();
  segment_started_ = false;
}

std::string VisualOdometry::refuse(const RgbdFrame& frame) const {
  if (frame.colour_bgr.empty() || frame.depth_mm.empty()) return "empty image";
  if (frame.colour_bgr.type() != CV_8UC3 || frame.depth_mm.type() != CV_16UC1)
    return "colour is not 8-bit BGR or depth is not 16-bit";
  const cv::Size size(camera_.width_px, camera_.height_px);
  if (frame.colour_bgr.size() != size || frame.depth_mm.size() != size)
    return "image size differs from the camera model's";
  if (last_utime_us_ != 0 && frame.utime_us <= last_utime_us_) return "older than the last frame";
  return "";
}

FeatureSet VisualOdometry::see(const RgbdFrame& frame) const {
  cv::Mat grey;
  cv::cvtColor(frame.colour_bgr, grey, cv::COLOR_BGR2GRAY);
  FeatureSet set = extractor_.extract(grey);
  attach_depth(frame.depth_mm, camera_, &set);
  undistort(camera_, &set);
  return set;
}

// A wide search around the guess, then a narrow one around what it gave; nothing when too little
// agrees.
std::optional<VisualOdometry::Estimate> VisualOdometry::track_map(const SE3& guess,
                                                                  const FeatureSet& set,
                                                                  double radius_px) const {
  const FeatureGrid grid(set.features, camera_.width_px, camera_.height_px);
  const Estimate rough = estimate_pose(guess, set, grid, radius_px);
  if (static_cast<int>(rough.matched.matches.size()) < config_.min_inliers) return std::nullopt;
  Estimate fine = estimate_pose(rough.T_odom_camera, set, grid, config_.narrow_radius_px);
  if (static_cast<int>(fine.matched.matches.size()) < config_.min_inliers) return std::nullopt;
  return fine;
}

VisualOdometry::Estimate VisualOdometry::estimate_pose(const SE3& guess, const FeatureSet& set,
                                                       const FeatureGrid& grid,
                                                       double radius_px) const {
  Estimate estimate;
  estimate.matched =
      match_by_projection(map_, camera_, guess, set, grid, scales_, radius_px, config_);
  std::vector<Correspondence> correspondences;
  for (const MapMatch& m : estimate.matched.matches) {
    const Feature& f = set.features[m.feature];
    correspondences.push_back(
        make_correspondence(map_.points().at(m.point), f, camera_, scales_[f.octave], config_));
  }
  const RefinedPose refined = refine_pose(camera_, correspondences, guess, config_.refine);
  estimate.T_odom_camera = refined.T_reference_camera;
  estimate.covariance = refined.covariance;
  std::vector<MapMatch> inliers;
  for (std::size_t i = 0; i < correspondences.size(); ++i)
    if (refined.inlier[i]) inliers.push_back(estimate.matched.matches[i]);
  estimate.matched.matches = std::move(inliers);
  return estimate;
}

TrackingResult VisualOdometry::tracked(std::int64_t utime_us, const Estimate& estimate,
                                       FeatureSet set) {
  for (const std::int64_t point : estimate.matched.in_view) map_.count_visible(point);
  for (const MapMatch& m : estimate.matched.matches) map_.count_found(m.point);
  motion_.update(utime_us, estimate.T_odom_camera);
  T_odom_camera_ = estimate.T_odom_camera;
  fix_utime_us_ = utime_us;

  TrackingResult result;
  result.utime_us = utime_us;
  result.n_matched = static_cast<int>(estimate.matched.matches.size());
  const bool weak = result.n_matched < config_.min_inliers_ok;
  result.state = weak ? TrackingState::kWeak : TrackingState::kOk;
  if (weak) result.reason = "only " + std::to_string(result.n_matched) + " features agree";
  result.covariance = in_base_axes(estimate.covariance, T_base_camera_);
  if (fresh_keyframe_) inliers_at_keyframe_ = result.n_matched;
  fresh_keyframe_ = false;

  KeyframeEvidence evidence;
  evidence.T_keyframe_camera = T_odom_keyframe_.inverse() * T_odom_camera_;
  evidence.median_depth_m = median_depth(set);
  evidence.n_inliers = result.n_matched;
  evidence.n_inliers_at_keyframe = inliers_at_keyframe_;
  if (decide_keyframe(evidence, config_) != KeyframeReason::kNone)
    add_keyframe(estimate, true, std::move(set), &result);
  fill_pose(T_odom_camera_, &result);
  return result;
}

// Nothing tracked: says so, and after a while (at once when there was no map) starts a new segment
// at the last pose.
TrackingResult VisualOdometry::lost(std::int64_t utime_us, FeatureSet set) {
  motion_.restart(T_odom_camera_);
  TrackingResult result;
  result.utime_us = utime_us;
  result.state = TrackingState::kLost;
  const int usable = with_depth(set);
  const bool patient = segment_started_ && utime_us - fix_utime_us_ < config_.lost_patience_us;
  if (patient || usable < config_.min_start_features) {
    result.reason = usable < config_.min_start_features
                        ? "only " + std::to_string(usable) + " features with depth"
                        : "no pose explains the features";
    fill_pose(T_odom_camera_, &result);
    return result;
  }
  const bool first = keyframe_id_ == 0;
  result.state = first ? TrackingState::kOk : TrackingState::kWeak;
  if (!first) result.reason = "new segment: the motion since the loss is unknown";
  fix_utime_us_ = utime_us;
  motion_.update(utime_us, T_odom_camera_);
  map_.clear();
  segment_started_ = true;
  Estimate here;
  here.T_odom_camera = T_odom_camera_;
  if (first) here.covariance = Matrix6d::Identity() * 1e-12;  // odom begins here
  result.covariance = in_base_axes(here.covariance, T_base_camera_);
  result.n_matched = usable;
  add_keyframe(here, false, std::move(set), &result);
  fill_pose(T_odom_camera_, &result);
  return result;
}

void VisualOdometry::add_keyframe(const Estimate& estimate, bool connected, FeatureSet set,
                                  TrackingResult* result) {
  std::vector<std::int64_t> point_of_feature(set.size(), 0);
  for (const MapMatch& m : estimate.matched.matches) point_of_feature[m.feature] = m.point;
  Keyframe keyframe;
  keyframe.id = keyframe_id_ + 1;
  keyframe.utime_us = result->utime_us;
  keyframe.T_odom_base = T_odom_camera_ * T_base_camera_.inverse();
  keyframe.covariance = result->covariance;
  if (connected) {
    keyframe.previous_id = keyframe_id_;
    keyframe.T_previous_base =
        T_base_camera_ * T_odom_keyframe_.inverse() * T_odom_camera_ * T_base_camera_.inverse();
  }
  keyframe_id_ = keyframe.id;
  T_odom_keyframe_ = T_odom_camera_;
  fresh_keyframe_ = true;
  map_.add_keyframe(keyframe.id, camera_, T_odom_camera_, set, scales_, config_.pixel_sigma,
                    config_.local_map_keyframes, &point_of_feature);
  keyframe.landmark_of_feature = std::move(point_of_feature);
  keyframe.features = std::move(set);
  result->keyframe = std::move(keyframe);
}

void VisualOdometry::fill_pose(const SE3& T_odom_camera, TrackingResult* result) const {
  const SE3 T_camera_base = T_base_camera_.inverse();
  result->T_odom_base = T_odom_camera * T_camera_base;
  result->reference_id = keyframe_id_;
  result->T_reference_base =
      T_base_camera_ * T_odom_keyframe_.inverse() * T_odom_camera * T_camera_base;
  result->fix_utime_us = fix_utime_us_;
}

}  // namespace fusion_slam
