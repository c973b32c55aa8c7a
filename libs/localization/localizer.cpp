#include "libs/localization/localizer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

namespace fusion_slam {
namespace {

template <class... Values>
std::string say(const char* format, Values... values) {
  char text[240];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

constexpr double kPinned = 1e-6;  // variance of what a flat map can't see: z, roll, pitch
constexpr std::int64_t kViewWaitUs = 1'000'000;
constexpr double kHint_m = 1.0;  // what a finger on a map is good for
constexpr double kHint_rad = 0.5;

Matrix6d from_planar(const Eigen::Matrix3d& planar) {
  Matrix6d full = Matrix6d::Identity() * kPinned;
  const int axes[] = {0, 1, 5};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) full(axes[r], axes[c]) = planar(r, c);
  return full;
}

double turn_between(const SE3& a, const SE3& b) {
  return log_so3(a.linear().transpose() * b.linear()).norm();
}

}  // namespace

Localizer::Localizer(const LocalizationMap& map)
    : map_(map), config_(map.config()), memory_(map.config()) {}

void Localizer::set_sensors(bool lidar, bool camera) {
  has_lidar_ = lidar;
  has_camera_ = camera;
}

bool Localizer::hint(const SE2& T_map_base, std::string* why) {
  const auto scan = nodes_.upper_bound({NodeKind::kLidar, INT64_MAX});
  if (!by_lidar() || scan == nodes_.begin()) {
    *why = "no scan has come yet to compare with the map";
    return false;
  }
  const Node& now = std::prev(scan)->second;
  SearchWindow window;
  window.linear_m = kHint_m;
  window.angular_rad = kHint_rad;
  const LidarFix fix =
      find_near(*map_.grid(), memory_.points_base(), T_map_base, window, config_.lidar);
  if (!fix.found) {
    *why = fix.reason;
    return false;
  }
  Answer answer;
  answer.T_map_odom = to_se3(fix.T_map_base) * now.T_odom_base.inverse();
  answer.covariance = from_planar(fix.covariance);
  answer.agreement = fix.agreement;
  localize(answer, now,
           say("a person said so, and %.0f %% of the LiDAR's points agree", 100 * fix.agreement));
  return true;
}

void Localizer::add_lidar_pose(std::int64_t utime_us, const SE3& T_odom_base) {
  lidar_track_.add(utime_us, T_odom_base);
  resolve_views();
}

void Localizer::lidar_lost() {
  if (!by_lidar()) return;
  lidar_track_.clear();
  views_.clear();
  forget("the LiDAR lost its track");
}

void Localizer::add_scan(const LocalScan& scan) {
  if (!by_lidar()) return;
  if (scan.starts_anew && !nodes_.empty()) {
    lidar_track_.clear();
    forget("the LiDAR lost its track");
  }
  lidar_track_.add(scan.utime_us, scan.T_odom_base);
  const Node now{scan.utime_us, scan.T_odom_base};
  nodes_[{NodeKind::kLidar, scan.id}] = now;
  memory_.add(scan.utime_us, to_se2(scan.T_odom_base), scan.points_base);
  if (state_ == LocalizationState::kLocalized) {
    track_by_lidar(scan);
  } else if (due_for_search(scan)) {
    search_by_lidar(scan);
    weigh(now);
  }
  resolve_views();
}

void Localizer::add_view(const LocalView& view) {
  if (by_lidar()) {
    views_.push_back(view);
    return resolve_views();
  }
  if (!by_camera()) return;
  if (view.starts_anew && !nodes_.empty()) forget("the camera lost its track");
  const Node now{view.utime_us, view.T_odom_base};
  nodes_[{NodeKind::kKeyframe, view.id}] = now;
  if (state_ == LocalizationState::kLocalized) return track_by_camera(view);
  search_by_camera(view, view.T_odom_base);
  weigh(now);
}

// A view is placed by the LiDAR's odometry at its time, which comes a little later.
void Localizer::resolve_views() {
  while (!views_.empty() && lidar_track_.reaches(views_.front().utime_us)) {
    const LocalView view = std::move(views_.front());
    views_.pop_front();
    const auto T_odom_base = lidar_track_.at(view.utime_us);
    if (!T_odom_base) continue;
    const NodeId id{NodeKind::kKeyframe, view.id};
    const Node now{view.utime_us, *T_odom_base};
    nodes_[id] = now;
    if (state_ == LocalizationState::kLocalized) {
      place(id, now, covariance_);
    } else if (by_camera()) {
      search_by_camera(view, *T_odom_base);
      weigh(now);
    }
  }
  while (views_.size() > 1 && views_.back().utime_us - views_.front().utime_us > kViewWaitUs)
    views_.pop_front();
}

bool Localizer::due_for_search(const LocalScan& scan) const {
  if (!searched_at_) return true;
  const double rarer = std::min(10.0, 1.0 + std::floor(static_cast<double>(vain_searches_) /
                                                       std::max(1, config_.patient_searches)));
  return (scan.T_odom_base.translation() - searched_at_->translation()).norm() >=
             rarer * config_.search_every_m ||
         turn_between(*searched_at_, scan.T_odom_base) >= rarer * config_.search_every_rad;
}

void Localizer::search_by_lidar(const LocalScan& scan) {
  ++searches_;
  ++vain_searches_;
  searched_at_ = scan.T_odom_base;
  const double rival_share = by_camera() ? 1.0 : config_.rival_score;
  const LidarFix fix = find_in_map(*map_.grid(), memory_.points_base(), rival_share, config_.lidar);
  score_ = fix.agreement;
  if (!fix.found) {
    reason_ = fix.reason;
    return;
  }
  Answer answer;
  answer.utime_us = scan.utime_us;
  answer.T_odom_base = scan.T_odom_base;
  answer.T_map_odom = to_se3(fix.T_map_base) * scan.T_odom_base.inverse();
  answer.covariance = from_planar(fix.covariance);
  answer.agreement = fix.agreement;
  answer.score = fix.score;
  answer.unique = fix.rival_score == 0.0;
  lidar_answers_.push_back(answer);
}

void Localizer::search_by_camera(const LocalView& view, const SE3& T_odom_base) {
  ++searches_;
  for (const VisualFix& fix : find_views(map_, view.features)) {
    Answer answer;
    answer.utime_us = view.utime_us;
    answer.T_odom_base = T_odom_base;
    answer.T_map_odom = fix.T_map_base * T_odom_base.inverse();
    answer.covariance = fix.covariance;
    answer.n_inliers = fix.n_inliers;
    answer.map_keyframe = fix.keyframe_id;
    camera_answers_.push_back(answer);
  }
}

// What the sensors have answered lately: enough to believe it?
void Localizer::weigh(const Node& now) {
  forget_old(now.utime_us);
  if (by_lidar() && by_camera()) {
    int weighed = 0;
    for (auto view = camera_answers_.rbegin();
         view != camera_answers_.rend() && weighed < config_.views_weighed; ++view, ++weighed)
      if (both_agree(*view, now)) return;
    if (weighed == 0 && !lidar_answers_.empty())
      candidate(lidar_answers_.back(), now, "the LiDAR has an idea, the camera knows no view here");
    return;
  }
  by_lidar() ? lidar_alone(now) : camera_alone(now);
}

// The camera's place must be among the LiDAR's best of the whole map.
bool Localizer::both_agree(const Answer& view, const Node& now) {
  if (lidar_answers_.empty()) {
    candidate(view, now, "the camera knows a view, the LiDAR fits nowhere");
    return false;
  }
  const Answer& best = lidar_answers_.back();
  Answer agreed = best;
  if (!same_place(best, view, now.T_odom_base)) {
    const auto scan = std::prev(nodes_.upper_bound({NodeKind::kLidar, INT64_MAX}));
    const SE3 T_map_base = view.T_map_odom * scan->second.T_odom_base;
    SearchWindow window;
    window.linear_m = config_.same_m;
    window.angular_rad = config_.same_rad;
    const LidarFix there =
        find_near(*map_.grid(), memory_.points_base(), to_se2(T_map_base), window, config_.lidar);
    if (!there.found || there.score < config_.among_best * best.score) {
      candidate(view, now, "camera and LiDAR name different places");
      return false;
    }
    agreed.T_map_odom = to_se3(there.T_map_base) * scan->second.T_odom_base.inverse();
    agreed.covariance = from_planar(there.covariance);
    agreed.agreement = there.agreement;
  }
  agreed.map_keyframe = view.map_keyframe;
  localize(agreed, now,
           say("a view with %d points of keyframe %lld, and %.0f %% of the LiDAR's points agree",
               view.n_inliers, static_cast<long long>(view.map_keyframe), 100 * agreed.agreement));
  return true;
}

bool Localizer::lidar_alone(const Node& now) {
  if (lidar_answers_.empty()) return false;
  const Answer& newest = lidar_answers_.back();
  int alike = 0;
  double way_m = 0.0, way_rad = 0.0;
  for (auto it = lidar_answers_.rbegin(); it != lidar_answers_.rend(); ++it) {
    if (!it->unique || it->agreement < config_.alone_agreement ||
        !same_place(*it, newest, now.T_odom_base))
      break;
    ++alike;
    way_m = (it->T_odom_base.translation() - newest.T_odom_base.translation()).norm();
    way_rad = std::max(way_rad, turn_between(it->T_odom_base, newest.T_odom_base));
  }
  const bool from_enough = way_m >= config_.alone_way_m || way_rad >= config_.alone_way_rad;
  if (alike >= config_.alone_answers && from_enough) {
    localize(
        newest, now,
        say("%d searches agree, %.0f %% of the LiDAR's points do", alike, 100 * newest.agreement));
    return true;
  }
  candidate(newest, now,
            !newest.unique ? "other places of the map fit about as well"
                           : say("%d of %d searches agree", alike, config_.alone_answers));
  return false;
}

bool Localizer::camera_alone(const Node& now) {
  if (camera_answers_.empty()) {
    reason_ = "the camera knows no view here";
    return false;
  }
  for (auto it = camera_answers_.rbegin(); it != camera_answers_.rend(); ++it) {
    int alike = 0;
    for (const Answer& other : camera_answers_) {
      const bool apart =
          (other.T_odom_base.translation() - it->T_odom_base.translation()).norm() >=
              config_.camera_apart_m ||
          turn_between(other.T_odom_base, it->T_odom_base) >= config_.camera_apart_rad;
      if ((apart || &other == &*it) && same_place(other, *it, now.T_odom_base)) ++alike;
    }
    if (alike < config_.camera_answers && it->n_inliers < config_.camera_sure_inliers) continue;
    localize(*it, now, say("%d views agree, the latest with %d points", alike, it->n_inliers));
    return true;
  }
  candidate(camera_answers_.back(), now, "one view is known; a second one has to agree");
  return false;
}

bool Localizer::same_place(const Answer& a, const Answer& b, const SE3& T_odom_base) const {
  const SE2 apart = to_se2((a.T_map_odom * T_odom_base).inverse() * (b.T_map_odom * T_odom_base));
  return std::hypot(apart.x, apart.y) <= config_.same_m && std::abs(apart.yaw) <= config_.same_rad;
}

void Localizer::candidate(const Answer& answer, const Node& now, const std::string& why) {
  state_ = LocalizationState::kCandidate;
  reason_ = why;
  here_ = PlacedNode{now.utime_us, answer.T_map_odom * now.T_odom_base, answer.covariance};
}

// All nodes of the track that led here get their place, too.
void Localizer::localize(const Answer& answer, const Node& now, const std::string& how) {
  state_ = LocalizationState::kLocalized;
  reason_ = how;
  T_map_odom_ = answer.T_map_odom;
  covariance_ = answer.covariance;
  score_ = answer.agreement > 0.0 ? answer.agreement : score_;
  contradictions_ = 0;
  localized_us_ = now.utime_us;
  for (const auto& [id, node] : nodes_) {
    place(id, node, covariance_);
    if (node.utime_us == now.utime_us) fixes_.push_back({id, placed_.at(id), answer.map_keyframe});
  }
  here_ = PlacedNode{now.utime_us, T_map_odom_ * now.T_odom_base, covariance_};
}

void Localizer::track_by_lidar(const LocalScan& scan) {
  const Node now{scan.utime_us, scan.T_odom_base};
  const NodeId id{NodeKind::kLidar, scan.id};
  SearchWindow window;
  window.linear_m = config_.track_window_m;
  window.angular_rad = config_.track_window_rad;
  const LidarFix fix = find_near(*map_.grid(), scan.points_base,
                                 to_se2(T_map_odom_ * scan.T_odom_base), window, config_.lidar);
  score_ = fix.agreement;
  const bool known_space = fix.coverage >= config_.lidar.min_coverage;
  if (known_space && fix.agreement >= config_.track_agreement) {
    T_map_odom_ = to_se3(fix.T_map_base) * scan.T_odom_base.inverse();
    covariance_ = from_planar(fix.covariance);
    contradictions_ = 0;
    reason_ = say("%.0f %% of the scan agrees with the map", 100 * fix.agreement);
    place(id, now, covariance_);
    fixes_.push_back({id, placed_.at(id), 0});
  } else {
    contradictions_ += known_space && fix.agreement < config_.lost_agreement ? 1 : 0;
    reason_ = known_space ? say("only %.0f %% of the scan agrees with the map", 100 * fix.agreement)
                          : std::string("beyond the map: by odometry");
    place(id, now, covariance_);
    if (contradictions_ >= config_.lost_after)
      return forget(say("%d scans in a row contradict the map", contradictions_));
  }
  here_ = placed_.at(id);
}

void Localizer::track_by_camera(const LocalView& view) {
  const Node now{view.utime_us, view.T_odom_base};
  const NodeId id{NodeKind::kKeyframe, view.id};
  Answer predicted;
  predicted.T_map_odom = T_map_odom_;
  bool known = false;
  for (const VisualFix& fix : find_views(map_, view.features)) {
    Answer answer;
    answer.T_map_odom = fix.T_map_base * view.T_odom_base.inverse();
    if (!same_place(answer, predicted, view.T_odom_base)) continue;
    T_map_odom_ = answer.T_map_odom;
    covariance_ = fix.covariance;
    known = true;
    place(id, now, covariance_);
    fixes_.push_back({id, placed_.at(id), fix.keyframe_id});
    reason_ = say("a view with %d points of keyframe %lld", fix.n_inliers,
                  static_cast<long long>(fix.keyframe_id));
    break;
  }
  if (!known) {
    place(id, now, covariance_);
    reason_ = "no view of the map here: by odometry";
  }
  here_ = placed_.at(id);
}

void Localizer::place(const NodeId& id, const Node& node, const Matrix6d& covariance) {
  const PlacedNode placed{node.utime_us, T_map_odom_ * node.T_odom_base, covariance};
  placed_[id] = placed;
  news_[id] = placed;
}

// The nodes that were placed stay where they are; what comes starts from nothing.
void Localizer::forget(const std::string& why) {
  state_ = LocalizationState::kUnknown;
  reason_ = why;
  here_.reset();
  memory_.clear();
  nodes_.clear();
  lidar_answers_.clear();
  camera_answers_.clear();
  searched_at_.reset();
  vain_searches_ = 0;
  contradictions_ = 0;
}

void Localizer::forget_old(std::int64_t utime_us) {
  for (auto* answers : {&lidar_answers_, &camera_answers_})
    while (!answers->empty() && utime_us - answers->front().utime_us > config_.answer_memory_us)
      answers->pop_front();
}

std::vector<std::pair<NodeId, PlacedNode>> Localizer::take_placed() {
  std::vector<std::pair<NodeId, PlacedNode>> news(news_.begin(), news_.end());
  news_.clear();
  return news;
}

std::vector<MapFix> Localizer::take_fixes() {
  std::vector<MapFix> fixes;
  fixes.swap(fixes_);
  return fixes;
}

}  // namespace fusion_slam
