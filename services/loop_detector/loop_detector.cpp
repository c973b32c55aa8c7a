#include "services/loop_detector/loop_detector.hpp"

#include <cmath>
#include <cstdio>
#include <iterator>
#include <utility>

namespace fusion_slam {
namespace {

std::string describe(const GeometryCheck& check, bool fits, bool precise) {
  char text[160];
  std::snprintf(text, sizeof text, "%d matches, %d agree on one motion", check.n_matches,
                check.n_inliers);
  std::string all = text;
  if (!fits) return all;
  std::snprintf(text, sizeof text, ", known to %.3f m and %.2f degrees%s", check.sigma_m,
                check.sigma_rad * 180.0 / M_PI, precise ? "" : ": vague");
  return all + text;
}

}  // namespace

LoopDetector::LoopDetector(const RobotModel& robot, const LoopDetectorConfig& config)
    : robot_(robot),
      config_(config),
      places_(config.appearance),
      graph_(robot.planar, config.noise),
      consistency_(config.consistency) {}

void LoopDetector::set_camera(const CameraModel& camera) {
  if (!camera_) camera_ = camera;
}

std::vector<LoopCandidate> LoopDetector::add(const LoopKeyframe& keyframe) {
  if (keyframe.id <= last_keyframe_) return {};
  std::vector<LoopCandidate> decided = consistency_.expired(keyframe.utime_us, false);
  for (const std::int64_t place : keep(keyframe)) thin_out(place);
  if (camera_)
    for (const PlaceIndex::Place& place : places_.like(keyframe.features)) {
      if (says_nothing_new(place.id, keyframe.id)) {
        ++counts_.nothing_new;
        continue;
      }
      for (LoopCandidate& candidate : examine(place, keyframe))
        decided.push_back(std::move(candidate));
    }
  return settle(std::move(decided));
}

std::vector<LoopCandidate> LoopDetector::add(const LoopScan& scan) {
  if (scan.id <= last_scan_) return {};
  keep(scan);
  std::vector<LoopCandidate> decided = consistency_.expired(scan.utime_us, false);
  if (due(scan))
    for (const Target& target : targets(scan))
      for (LoopCandidate& candidate : search(scan, target)) decided.push_back(std::move(candidate));
  return settle(std::move(decided));
}

void LoopDetector::remember(const LoopKeyframe& keyframe) {
  if (keyframe.id <= last_keyframe_) return complete(keyframe);
  const NodeId last{NodeKind::kKeyframe, last_keyframe_};
  if (retired_before_.count(keyframe.id) > 0) {
    ++counts_.keyframes;
    ++counts_.retired;
    last_keyframe_ = keyframe.id;
    graph_.add(keyframe);
  } else {
    keep(keyframe);
  }
  if (retired_before_.erase(last.id) > 0) graph_.retire(last);  // its successor hangs on it no more
}

// One that was restored without its features.
void LoopDetector::complete(const LoopKeyframe& keyframe) {
  if (kept_before_.erase(keyframe.id) == 0) return;
  if (retired_before_.count(keyframe.id) == 0) return void(keep_features(keyframe));
  ++counts_.retired;
  if (keyframe.id == last_keyframe_) return;  // its successor will hang on it
  retired_before_.erase(keyframe.id);
  graph_.retire({NodeKind::kKeyframe, keyframe.id});
}

// Returned: keyframes that are old enough to be places now.
std::vector<std::int64_t> LoopDetector::keep(const LoopKeyframe& keyframe) {
  ++counts_.keyframes;
  last_keyframe_ = keyframe.id;
  graph_.add(keyframe);
  return keep_features(keyframe);
}

std::vector<std::int64_t> LoopDetector::keep_features(const LoopKeyframe& keyframe) {
  keyframe_times_[keyframe.utime_us] = keyframe.id;
  keyframes_.emplace(keyframe.id, keyframe);
  return places_.add(keyframe.id, keyframe.utime_us, keyframe.features);
}

void LoopDetector::remember(const LoopScan& scan) {
  scan.id > last_scan_ ? keep(scan) : keep_points(scan);
}

void LoopDetector::keep(const LoopScan& scan) {
  if (scan.previous_id == 0) chain_begins_at_ = scan.id;
  last_scan_ = scan.id;
  ++counts_.scans;
  graph_.add(scan);
  submaps_.add_scan(scan);
  links_.push_back(scan.id);
  forget_old_scans();
  keep_points(scan);
}

void LoopDetector::keep_points(const LoopScan& scan) {
  scans_[scan.id] = {scan.seq, scan.points_base};
  if (scans_.size() > config_.latest_scans) scans_.erase(scans_.begin());
}

std::vector<LoopCandidate> LoopDetector::finish() { return settle(consistency_.expired(0, true)); }

void LoopDetector::switched_off(const NodeId& from, const NodeId& to) {
  graph_.remove_loop(from, to);
  consistency_.forget(from, to);
}

LoopDetector::Sizes LoopDetector::sizes() const {
  return {places_.n_places(), keyframes_.size(), graph_.n_nodes(), graph_.n_edges(),
          submaps_.all().size()};
}

// Stages 2 to 4 of a place that looks like this one.
std::vector<LoopCandidate> LoopDetector::examine(const PlaceIndex::Place& place,
                                                 const LoopKeyframe& keyframe) {
  LoopCandidate candidate;
  candidate.from = {NodeKind::kKeyframe, place.id};
  candidate.to = {NodeKind::kKeyframe, keyframe.id};
  candidate.utime_us = keyframe.utime_us;
  candidate.stages.push_back({"appearance", place.share, config_.appearance.min_votes, true,
                              "share of the features asked that were seen there"});

  const LoopKeyframe& older = keyframes_.at(place.id);
  const GeometryCheck check =
      check_geometry(*camera_, older.features, keyframe.features, config_.geometry);
  const bool fits = check.n_inliers >= config_.geometry.min_inliers;
  const bool precise = is_precise(check, config_.geometry);
  candidate.stages.push_back({"geometry", static_cast<double>(check.n_inliers),
                              static_cast<double>(config_.geometry.min_inliers), fits,
                              describe(check, fits, precise)});
  if (!fits) return weigh(std::move(candidate), 0);

  LoopMeasurement visual;
  visual.from = candidate.from;
  visual.to = candidate.to;
  visual.T_from_to = robot_.T_base_camera * check.T_older_newer * robot_.T_base_camera.inverse();
  visual.covariance =
      config_.geometry.optimism * in_base_axes(check.covariance, robot_.T_base_camera);
  visual.same_features = check.same;
  visual.by = "visual loop";
  candidate.measurements.push_back(visual);

  LidarOpinion opinion = LidarOpinion::kNothing;
  candidate.stages.push_back(verify_by_lidar(older, keyframe, !precise, &candidate, &opinion));
  if (opinion == LidarOpinion::kNowhere) return weigh(std::move(candidate), 0);
  if (!precise && opinion != LidarOpinion::kFits) {
    candidate.stages.back().reason += ", and the camera's answer is too vague";
    return weigh(std::move(candidate), 0);
  }
  const ConsistencyConfig& need = config_.consistency;
  if (opinion == LidarOpinion::kFits) {
    candidate.source = LoopSource::kBoth;
    return weigh(std::move(candidate), need.both_sensors_alike);
  }
  const bool sure = check.n_inliers >= need.vision_sure_inliers && !robot_.has_lidar;
  return weigh(std::move(candidate), sure ? 1 : need.vision_alike);
}

// Stage 4. `alike` 0: an earlier stage has failed.
std::vector<LoopCandidate> LoopDetector::weigh(LoopCandidate candidate, int alike) {
  ++counts_.candidates;
  if (candidate.stages.size() == 2)
    candidate.stages.push_back({"lidar", 0.0, 0.0, false, "not asked: an earlier stage failed"});
  if (alike == 0) {
    candidate.stages.push_back(
        {"consistency", 0.0, 0.0, false, "not asked: an earlier stage failed"});
    return {candidate};
  }
  const Consistency::Gate gate = consistency_.gate(graph_, candidate.measurements.front());
  candidate.stages.push_back(
      {"consistency", gate.squared_distance, gate.threshold, gate.inside, gate.reason});
  if (!gate.inside) return {candidate};
  if (gate.sigma_m > config_.consistency.far_sigma_m) ++alike;
  return consistency_.judge(graph_, std::move(candidate), alike);
}

// What was accepted is an edge of the graph from now on.
std::vector<LoopCandidate> LoopDetector::settle(std::vector<LoopCandidate> decided) {
  for (const LoopCandidate& candidate : decided) {
    if (!candidate.accepted) continue;
    ++counts_.accepted;
    for (const LoopMeasurement& loop : candidate.measurements) graph_.add_loop(loop);
  }
  return decided;
}

}  // namespace fusion_slam
