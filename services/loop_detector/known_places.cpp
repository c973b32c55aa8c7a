// Places that were seen many times. Of their views the oldest and the newest are kept, so that what
// is kept, and what a question costs, grows with the area and not with time; and a view that would
// tell the graph nothing new there is not compared.
#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>

#include "services/loop_detector/loop_detector.hpp"

namespace fusion_slam {
namespace {

template <int N>
double worst_sigma(const Eigen::Matrix<double, N, N>& covariance) {
  return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, N, N>>(
                                     covariance, Eigen::EigenvaluesOnly)
                                     .eigenvalues()
                                     .maxCoeff()));
}

bool known_within(const GraphKnowledge::Relative& relative, bool planar, double sigma_m,
                  double sigma_rad) {
  if (!relative.connected) return false;
  const Matrix6d& c = relative.covariance;
  if (planar)
    return worst_sigma<2>(c.topLeftCorner<2, 2>()) <= sigma_m && std::sqrt(c(5, 5)) <= sigma_rad;
  return worst_sigma<3>(c.topLeftCorner<3, 3>()) <= sigma_m &&
         worst_sigma<3>(c.bottomRightCorner<3, 3>()) <= sigma_rad;
}

}  // namespace

// The places, by id, that show what this one shows, and are surely there.
std::vector<std::int64_t> LoopDetector::views_like(std::int64_t keyframe) const {
  const KnownPlacesConfig& config = config_.known;
  std::vector<std::int64_t> views;
  const NodeId here{NodeKind::kKeyframe, keyframe};
  const auto T_map_here = graph_.T_map_base(here);
  if (!T_map_here) return views;
  GraphUncertainty::Paths paths = graph_.paths_from(here);
  for (const auto& [id, label] : places_.places()) {
    const NodeId there{NodeKind::kKeyframe, id};
    const auto T_map_there = graph_.T_map_base(there);
    if (!T_map_there ||
        (T_map_there->translation() - T_map_here->translation()).norm() > config.near_m ||
        local(*T_map_here, *T_map_there).tail<3>().norm() > config.near_rad)
      continue;
    const auto relative = graph_.relative(&paths, here, there);
    if (relative &&
        known_within(*relative, graph_.planar(), config.most_sigma_m, config.most_sigma_rad))
      views.push_back(id);
  }
  return views;
}

// A keyframe has become a place: what was seen there between the oldest and the newest times goes.
void LoopDetector::thin_out(std::int64_t keyframe) {
  const KnownPlacesConfig& config = config_.known;
  const std::vector<std::int64_t> views = views_like(keyframe);  // itself among them
  const std::size_t kept = config.oldest + config.newest;
  if (views.size() <= kept) return;
  std::size_t visits = 1;
  bool known = false;
  for (std::size_t i = 0; i < views.size(); ++i) {
    known = known || known_places_.count(views[i]) > 0;
    if (i > 0 && keyframes_.at(views[i]).utime_us - keyframes_.at(views[i - 1]).utime_us >
                     config.visit_gap_us)
      ++visits;
  }
  if (!known && visits < config.fewest_visits) return;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const NodeId id{NodeKind::kKeyframe, views[i]};
    const bool between = i >= config.oldest && i + config.newest < views.size();
    if (between && !consistency_.waits_for(id))
      retire(id);
    else if (known_places_.insert(views[i]).second)
      news_.known.push_back(id);
  }
}

void LoopDetector::retire(const NodeId& keyframe) {
  const auto found = keyframes_.find(keyframe.id);
  if (found == keyframes_.end()) return;
  const std::int64_t utime_us = found->second.utime_us;
  places_.remove(keyframe.id);
  keyframe_times_.erase(utime_us);
  keyframes_.erase(found);
  known_places_.erase(keyframe.id);
  news_.retired.push_back(keyframe);
  ++counts_.retired;
  graph_.retire(keyframe);
  for (const NodeId& scan : graph_.scans_near(utime_us, config_.scan_gap_us))
    if (last_scan_ - scan.id > config_.known.latest_links && is_mere_link(scan)) forget_scan(scan);
}

// At a known place, what the graph knows of the way there as well as a scan or a view would tell.
bool LoopDetector::says_nothing_new(std::int64_t place, std::int64_t keyframe) const {
  if (known_places_.count(place) == 0) return false;
  const auto known = graph_.relative({NodeKind::kKeyframe, keyframe}, {NodeKind::kKeyframe, place});
  return known && known_within(*known, graph_.planar(), config_.known.tells_nothing_m,
                               config_.known.tells_nothing_rad);
}

// Stands for no place, begins no submap, and no loop may need it.
bool LoopDetector::is_mere_link(const NodeId& scan) const {
  const auto utime_us = graph_.utime_us(scan);
  if (!utime_us || submaps_.all().count(scan.id) > 0 || consistency_.mentions(scan)) return false;
  for (auto keyframe = keyframe_times_.lower_bound(*utime_us - config_.scan_gap_us);
       keyframe != keyframe_times_.end() && keyframe->first <= *utime_us + config_.scan_gap_us;
       ++keyframe)
    if (graph_.scan_near(keyframe->first, config_.scan_gap_us) == scan) return false;
  return true;
}

void LoopDetector::forget_scan(const NodeId& scan) {
  graph_.retire(scan);
  submaps_.forget_scan(scan.id);
}

// Older scans that are mere links of the chain go: paths through them stay what they were.
void LoopDetector::forget_old_scans() {
  std::vector<std::int64_t> later;
  while (!links_.empty() && last_scan_ - links_.front() > config_.known.latest_links) {
    const NodeId scan{NodeKind::kLidar, links_.front()};
    links_.pop_front();
    if (is_mere_link(scan))
      forget_scan(scan);
    else if (consistency_.mentions(scan))
      later.push_back(scan.id);
  }
  links_.insert(links_.end(), later.begin(), later.end());  // asked again with the next ones
}

KnownPlacesNews LoopDetector::take_news() { return std::exchange(news_, {}); }

void LoopDetector::remember(const KnownPlacesNews& news) {
  for (const NodeId& id : news.retired) {
    retired_before_.insert(id.id);
    known_places_.erase(id.id);
  }
  for (const NodeId& id : news.known) known_places_.insert(id.id);
}

}  // namespace fusion_slam
