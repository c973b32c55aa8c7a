#include "services/visual_odometry/visual_odometry.hpp"

#include <algorithm>

#include "libs/features/pose_refiner.hpp"
#include "services/visual_odometry/frames_ahead.hpp"
#include "services/visual_odometry/lidar_depth.hpp"
#include "services/visual_odometry/relocaliser.hpp"

namespace fusion_slam {
namespace {

int with_depth(const FeatureSet& set) {
  return static_cast<int>(std::count_if(set.features.begin(), set.features.end(),
                                        [](const Feature& f) { return f.depth_m > 0.0F; }));
}

// Products of rotations leave SO(3) little by little, and inverse() takes them at their word: fed
// back keyframe after keyframe, rounding would double each time.
SE3 normalised(const SE3& T) {
  const Eigen::Quaterniond q(T.linear());
  return make_pose(T.translation(), q.w(), q.x(), q.y(), q.z());
}

// A robot whose base stays on the floor says so in its model; a camera in a hand doesn't.
VisualOdometryConfig with_planar_prior(VisualOdometryConfig config, const RobotModel& robot) {
  if (!config.use_planar || !robot.planar) return config;
  config.refine.planar.emplace();
  config.refine.planar->T_base_camera = robot.T_base_camera;
  return config;
}

std::vector<double> scales_of(const OrbExtractor& extractor, int n_levels) {
  std::vector<double> scales;
  scales.reserve(static_cast<std::size_t>(n_levels));
  for (int i = 0; i < n_levels; ++i) scales.push_back(extractor.scale(i));
  return scales;
}

}  // namespace

VisualOdometry::VisualOdometry(const CameraModel& camera, const RobotModel& robot,
                               const VisualOdometryConfig& config)
    : config_(with_planar_prior(config, robot)),
      camera_(camera),
      robot_(robot),
      extractor_(config.orb),
      scales_(scales_of(extractor_, config.orb.n_levels)),
      mapping_(camera, scales_, config_),
      T_odom_camera_(robot.T_base_camera) {}

TrackingResult VisualOdometry::track(const RgbdFrame& frame, const FeatureSet* features) {
  TrackingResult refused;
  refused.utime_us = frame.utime_us;
  refused.reason = refuse(frame);
  if (!refused.reason.empty()) {
    fill_pose(T_odom_camera_, &refused);
    return refused;
  }
  look_at_clock(frame.utime_us);
  last_utime_us_ = frame.utime_us;
  take_up_news();
  if (config_.use_surfaces) now_ = SeenSurfaces(frame.depth_mm);
  TrackingResult result = place(frame, features);
  if (result.keyframe) surfaces_of_keyframe_ = now_;
  if (result.keyframe) surfaces_keyframe_ = result.keyframe->id;
  surfaces_ = result.state == TrackingState::kLost ? SeenSurfaces{} : std::exchange(now_, {});
  return result;
}

// Where the frame was seen from.
TrackingResult VisualOdometry::place(const RgbdFrame& frame, const FeatureSet* features) {
  FeatureSet set = see(frame, features);
  if (!segment_started_) return lost(frame.utime_us, "", std::move(set));

  std::string why = "no pose explains the features";
  std::optional<PoseEstimate> estimate = track_from(guesses(frame.utime_us), set);
  const bool refuted = estimate && contradicts_lidar(frame.utime_us, *estimate, set.size());
  if (refuted) {
    why = "few features agree, and not with the LiDAR's motion";
    estimate.reset();
  }
  if (!estimate || static_cast<int>(estimate->matched.matches.size()) < config_.min_inliers_ok)
    if (auto carried = carry_on(frame.utime_us, set)) estimate = std::move(carried);
  if (!estimate) estimate = find_again(frame.utime_us, set, refuted);
  if (!estimate) return lost(frame.utime_us, why, std::move(set));
  return tracked(frame.utime_us, *estimate, std::move(set));
}

void VisualOdometry::reset() {
  if (mapping_.busy()) finish_mapping();
  mapped_ = newest_;
  map_ = {};
  local_.clear();
  places_ = {};
  revision_ = {};
  thinning_ = {};
  open_.clear();
  surfaces_ = {};
  surfaces_of_keyframe_ = {};
  surfaces_keyframe_ = 0;
  n_segments_ = 0;
  segment_started_ = false;
}

void VisualOdometry::add_scan(LaserScan scan) { scan_ = std::move(scan); }

void VisualOdometry::add_lidar_pose(std::int64_t utime_us, const SE3& T_odom_base) {
  lidar_motion_.add(utime_us, T_odom_base);
}

void VisualOdometry::add_graph_node(std::int64_t keyframe_id, const SE3& T_map_base) {
  if (map_.keyframe(keyframe_id) != nullptr) revision_.update(keyframe_id, T_map_base);
}

// Frames come in their order, so one that is a second older than the last is newer, by a clock that
// was set back.
bool VisualOdometry::was_set_back(std::int64_t utime_us) const {
  constexpr std::int64_t kBack_us = 1'000'000;
  return last_utime_us_ != 0 && utime_us <= last_utime_us_ - kBack_us;
}

// What was measured by the other clock is not compared with what comes now.
void VisualOdometry::look_at_clock(std::int64_t utime_us) {
  if (!was_set_back(utime_us)) return;
  last_utime_us_ = pose_utime_us_ = fix_utime_us_ = utime_us - 1;
  searching_since_us_ = 0;
  motion_.restart(T_odom_camera_);
  lidar_motion_.clear();
  scan_.reset();
}

std::string VisualOdometry::refuse(const RgbdFrame& frame) const {
  if (frame.colour_bgr.empty() || frame.depth_mm.empty()) return "empty image";
  if (frame.colour_bgr.type() != CV_8UC3 || frame.depth_mm.type() != CV_16UC1)
    return "colour is not 8-bit BGR or depth is not 16-bit";
  const cv::Size size(camera_.width_px, camera_.height_px);
  if (frame.colour_bgr.size() != size || frame.depth_mm.size() != size)
    return "image size differs from the camera model's";
  if (last_utime_us_ != 0 && frame.utime_us <= last_utime_us_ && !was_set_back(frame.utime_us))
    return "older than the last frame";
  return "";
}

FeatureSet VisualOdometry::see(const RgbdFrame& frame, const FeatureSet* features) {
  FeatureSet set = features != nullptr ? *features : find_features(extractor_, camera_, frame);
  const bool fresh = scan_ && std::abs(frame.utime_us - scan_->utime_us) <= config_.scan_age_us;
  if (config_.use_lidar_depth && fresh) {
    constexpr double kStep_s = 0.05;
    const SE3 moved = robot_.T_base_camera *
                      retract(SE3::Identity(), motion_.velocity() * kStep_s) *
                      robot_.T_base_camera.inverse();
    const Vector6d twist = local(SE3::Identity(), moved) / kStep_s;
    const ScanInBase scan = scan_at(*scan_, robot_, twist, frame.utime_us);
    counts_.lidar_depths += attach_lidar_depth(scan, robot_, camera_, config_, &set);
  }
  return set;
}

// The points where other threads and processes meet tracking: between two frames only.
void VisualOdometry::take_up_news() {
  ++frames_since_keyframe_;
  const auto due = [&] {
    return config_.wait_for_mapping ? frames_since_keyframe_ >= config_.mapping_frames
                                    : mapping_.ready();
  };
  if (mapping_.busy() && due()) finish_mapping();
  if (mapping_.busy()) return;
  if (follow_graph()) renew_local_map();
  if (newest_ > mapped_) start_mapping();
}

// The map is to itself: the mapping thread has no copy of it.
bool VisualOdometry::follow_graph() {
  const Revised revised = revision_.take_up(newest_, robot_.T_base_camera, config_, &map_);
  if (revised.keyframes.empty()) return false;
  counts_.revised_keyframes += static_cast<int>(revised.keyframes.size());
  places_.add_landmarks(map_, revised.landmarks);
  for (const std::int64_t id : revised.keyframes)  // the graph's answer is no measurement for it
    for (auto edge = open_.begin(); edge != open_.end();)
      edge = edge->second == id ? open_.erase(edge) : std::next(edge);
  return true;
}

std::map<std::int64_t, std::int64_t> VisualOdometry::finish_mapping() {
  const SE3 T_before = T_odom_reference();
  counts_.mapping_waits += mapping_.ready() ? 0 : 1;
  const MappingResult result = mapping_.finish(&map_);
  // The camera goes where its reference goes.
  const SE3 T_new_old = normalised(T_odom_reference() * T_before.inverse());
  T_odom_camera_ = normalised(T_new_old * T_odom_camera_);
  motion_.move(T_new_old);
  renew_local_map();
  ++counts_.mappings;
  counts_.triangulated += result.n_triangulated;
  counts_.fused += result.n_fused;
  counts_.observations_refused += result.bundle.n_outliers;
  counts_.landmarks_culled += result.n_landmarks_culled;
  counts_.keyframes_culled += result.n_keyframes_culled;
  return {result.part.merged().begin(), result.part.merged().end()};
}

void VisualOdometry::renew_local_map() {
  local_ = make_local_map(
      map_, local_keyframes(map_, segment_, T_odom_camera_, camera_, scales_, config_));
}

SE3 VisualOdometry::T_odom_reference() const {
  const MapKeyframe* keyframe = map_.keyframe(reference_);
  return keyframe == nullptr ? robot_.T_base_camera : keyframe->T_odom_camera;
}

std::optional<SE3> VisualOdometry::lidar_prediction(std::int64_t utime_us) const {
  if (!config_.use_lidar_motion) return std::nullopt;
  const std::optional<SE3> moved = lidar_motion_.between(pose_utime_us_, utime_us);
  if (!moved) return std::nullopt;
  return T_odom_camera_ * robot_.T_base_camera.inverse() * *moved * robot_.T_base_camera;
}

// Where the camera may be, likeliest first: as it moved before; as the LiDAR says, which goes first
// when vision was weak.
std::vector<VisualOdometry::Guess> VisualOdometry::guesses(std::int64_t utime_us) const {
  std::vector<Guess> result{{motion_.predict(utime_us), false}};
  if (const std::optional<SE3> predicted = lidar_prediction(utime_us))
    result.insert(weak_ ? result.begin() : result.end(), {*predicted, true});
  return result;
}

std::optional<PoseEstimate> VisualOdometry::track_from(const std::vector<Guess>& guesses,
                                                       const FeatureSet& set) {
  for (const Guess& guess : guesses) {
    auto estimate = track_local_map(local_, camera_, guess.T_odom_camera, set, scales_,
                                    config_.wide_radius_px, config_);
    if (!estimate) continue;
    counts_.lidar_guesses += guess.by_lidar ? 1 : 0;
    return estimate;
  }
  return track_local_map(local_, camera_, T_odom_camera_, set, scales_,
                         2.0 * config_.wide_radius_px, config_);
}

// Features fail: surfaces tell what they can, the LiDAR (or, without one, the speed) the rest. Not
// for long.
std::optional<PoseEstimate> VisualOdometry::carry_on(std::int64_t utime_us, const FeatureSet& set) {
  const bool bare =
      static_cast<double>(set.size()) < config_.carry_features * config_.orb.n_features;
  if (!bare || utime_us - fix_utime_us_ > config_.carry_us) return std::nullopt;
  // The floor comes in with the features.
  const SE3 guess = lidar_prediction(utime_us).value_or(motion_.predict(utime_us));
  const auto motion = track_surfaces(surfaces_.view(camera_, config_.surfaces), T_odom_camera_,
                                     now_.view(camera_, config_.surfaces), guess, camera_, nullptr,
                                     config_.surfaces);
  if (!motion) return std::nullopt;
  ++counts_.carried_frames;
  CameraPosePrior prior;
  prior.T_reference_camera = motion->T_odom_camera;
  prior.information = motion->covariance.inverse();
  PoseEstimate estimate = track_from_prior(local_, camera_, prior, set, scales_, config_);
  carried_ += estimate.covariance;
  if (static_cast<int>(estimate.matched.matches.size()) < config_.min_inliers)
    estimate.covariance = carried_;
  return estimate;
}

// Without any guess: the last places, and those of the whole map that look alike. After the LiDAR
// has refuted a pose not the same one by another way.
std::optional<PoseEstimate> VisualOdometry::find_again(std::int64_t utime_us, const FeatureSet& set,
                                                       bool refuted) {
  if (mapping_.busy() && config_.wait_for_mapping) finish_mapping();
  std::vector<std::int64_t> candidates{newest_};
  for (const std::int64_t id : places_.similar(map_, set, kNoSegment, config_.reloc_candidates))
    if (id != newest_) candidates.push_back(id);
  const int enough = resumed_ ? config_.min_inliers_ok : config_.reloc_inliers;
  auto found = relocalise(map_, candidates, camera_, set, scales_, enough, config_);
  if (!found) return std::nullopt;
  if (refuted && contradicts_lidar(utime_us, found->estimate, set.size())) return std::nullopt;
  reference_ = found->keyframe;
  segment_ = map_.keyframe(reference_)->segment;
  local_ = std::move(found->local);
  motion_.restart(found->estimate.T_odom_camera);
  found_again_ = true;
  ++counts_.relocalisations;
  return found->estimate;
}

// A few features of many agree by chance with a pose that isn't so; two sensors rarely with the
// same one.
bool VisualOdometry::contradicts_lidar(std::int64_t utime_us, const PoseEstimate& estimate,
                                       std::size_t n_features) const {
  const std::size_t agree = estimate.matched.matches.size();
  const bool few = agree < static_cast<std::size_t>(config_.min_inliers_ok);
  const double share = static_cast<double>(agree) / static_cast<double>(n_features);
  if (!few && share >= config_.doubted_share) return false;
  const std::optional<SE3> predicted = lidar_prediction(utime_us);
  // Nothing tells how far the robot went while this process was dead.
  if (!predicted) return few && resumed_;
  const Vector6d apart = local(*predicted, estimate.T_odom_camera);
  return apart.head<3>().norm() > config_.disagree_m ||
         apart.tail<3>().norm() > config_.disagree_rad;
}

TrackingResult VisualOdometry::tracked(std::int64_t utime_us, const PoseEstimate& estimate,
                                       FeatureSet set) {
  count_looks(estimate);
  resumed_ = false;
  T_odom_camera_ = normalised(estimate.T_odom_camera);
  motion_.update(utime_us, T_odom_camera_);
  pose_utime_us_ = utime_us;
  searching_since_us_ = 0;

  TrackingResult result;
  result.utime_us = utime_us;
  result.n_matched = static_cast<int>(estimate.matched.matches.size());
  const bool by_features = result.n_matched >= config_.min_inliers;
  if (by_features) fix_utime_us_ = utime_us;
  if (by_features) carried_.setZero();
  weak_ = result.n_matched < config_.min_inliers_ok;
  result.state = weak_ ? TrackingState::kWeak : TrackingState::kOk;
  if (weak_) result.reason = "only " + std::to_string(result.n_matched) + " features agree";
  if (!by_features) result.reason = "too few features: surfaces and the speed carry the pose";
  result.covariance = in_base_axes(estimate.covariance, robot_.T_base_camera);
  if (wants_keyframe(estimate, set))
    add_keyframe(landmarks_in(estimate), true, std::move(set), &result);
  fill_pose(T_odom_camera_, &result);
  return result;
}

void VisualOdometry::count_looks(const PoseEstimate& estimate) {
  for (const int point : estimate.matched.in_view)
    if (Landmark* landmark = map_.landmark(local_[point].landmark)) ++landmark->visible;
  for (const MapMatch& m : estimate.matched.matches)
    if (Landmark* landmark = map_.landmark(local_[m.point].landmark)) ++landmark->found;
}

// Nothing tracked: says so; where it is, the LiDAR knows or nobody. After a while of seeing
// something unknown (at once when there was no map) a new segment starts.
TrackingResult VisualOdometry::lost(std::int64_t utime_us, const std::string& why, FeatureSet set) {
  const std::optional<SE3> bridged = segment_started_ ? lidar_prediction(utime_us) : std::nullopt;
  if (bridged) {
    T_odom_camera_ = normalised(*bridged);
    pose_utime_us_ = utime_us;
  }
  motion_.restart(T_odom_camera_);
  weak_ = true;
  const int usable = with_depth(set);
  const bool sees = usable >= config_.min_start_features;
  if (!sees) searching_since_us_ = 0;
  if (sees && searching_since_us_ == 0) searching_since_us_ = utime_us;
  if (sees && (!segment_started_ || utime_us - searching_since_us_ >= config_.lost_patience_us))
    return start_segment(utime_us, std::move(set));

  TrackingResult result;
  result.utime_us = utime_us;
  result.state = TrackingState::kLost;
  result.reason = sees ? why : "only " + std::to_string(usable) + " features with depth";
  if (bridged) result.reason += "; the LiDAR bridges";
  fill_pose(T_odom_camera_, &result);
  return result;
}

TrackingResult VisualOdometry::start_segment(std::int64_t utime_us, FeatureSet set) {
  if (mapping_.busy() && config_.wait_for_mapping) finish_mapping();
  const bool first = newest_ == 0;
  TrackingResult result;
  result.utime_us = utime_us;
  result.state = first ? TrackingState::kOk : TrackingState::kWeak;
  if (!first) result.reason = "new segment: the motion since the loss is unknown";
  result.n_matched = with_depth(set);
  const Matrix6d covariance =
      first ? Matrix6d(Matrix6d::Identity() * 1e-12) : Matrix6d::Identity();  // odom begins here
  result.covariance = in_base_axes(covariance, robot_.T_base_camera);
  fix_utime_us_ = utime_us;
  pose_utime_us_ = utime_us;
  searching_since_us_ = 0;
  motion_.update(utime_us, T_odom_camera_);
  segment_started_ = true;
  resumed_ = false;
  ++segment_;
  ++n_segments_;
  add_keyframe({}, false, std::move(set), &result);
  fill_pose(T_odom_camera_, &result);
  return result;
}

void VisualOdometry::fill_pose(const SE3& T_odom_camera, TrackingResult* result) const {
  const SE3 T_camera_base = robot_.T_base_camera.inverse();
  result->T_odom_base = T_odom_camera * T_camera_base;
  result->reference_id = reference_;
  result->T_reference_base =
      robot_.T_base_camera * T_odom_reference().inverse() * T_odom_camera * T_camera_base;
  result->fix_utime_us = fix_utime_us_;
}

}  // namespace fusion_slam
