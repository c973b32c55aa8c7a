#include "logplayer/loops/loop_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "fusion_slam/graph_node_t.hpp"
#include "libs/messages/convert.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kTruthGap_us = 250'000;
constexpr double kStep_m = 1.0;  // revisits are counted by the metre

NodeId node_id(std::int8_t kind, std::int64_t id) {
  return {kind == graph_node_t::LIDAR ? NodeKind::kLidar : NodeKind::kKeyframe, id};
}

std::string name(const NodeId& id) {
  return (id.kind == NodeKind::kLidar ? "scan " : "keyframe ") + std::to_string(id.id);
}

template <class... Values>
std::string say(const char* format, Values... values) {
  char text[300];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

}  // namespace

void LoopReport::on_constraint(const constraint_t& message) {
  if (const auto T = from_message(message.T_from_to))
    closures_.push_back({node_id(message.from_kind, message.from_id),
                         node_id(message.to_kind, message.to_id), *T, message.source});
}

void LoopReport::on_graph(const graph_t& message) {
  graph_loops_ = message.n_loops;
  if (message.part == 0) switched_off_ = message.switched_off;
}

// Interpolated between the two true poses around the node's time.
std::optional<SE3> LoopReport::true_pose(const NodeId& id) const {
  const auto utime = utime_of_.find(id);
  if (utime == utime_of_.end()) return std::nullopt;
  // The truth often begins with the second message.
  const bool is_early = !truth_.empty() && utime->second < truth_.begin()->first;
  if (is_early && truth_.begin()->first - utime->second <= kTruthGap_us)
    return truth_.begin()->second;
  return pose_at(truth_, utime->second, kTruthGap_us);
}

std::optional<Vector6d> LoopReport::true_error(const Closure& closure) const {
  const auto from = true_pose(closure.from);
  const auto to = true_pose(closure.to);
  if (!from || !to) return std::nullopt;
  return local(SE3(from->inverse() * *to), closure.T_from_to);
}

std::optional<ClosureTruth> LoopReport::judge(const LoopReportOptions& options) const {
  if (truth_.empty()) return std::nullopt;
  ClosureTruth judged;
  std::vector<double> errors_m;
  std::vector<std::int64_t> closed_at;
  for (const Closure& closure : closures_) {
    const auto error = true_error(closure);
    if (!error) continue;
    ++judged.judged;
    errors_m.push_back(error->head<3>().norm());
    closed_at.push_back(utime_of_.at(closure.to));
    if (errors_m.back() > options.wrong_m || error->tail<3>().norm() > options.wrong_rad)
      ++judged.wrong;
  }
  if (!errors_m.empty()) {
    std::sort(errors_m.begin(), errors_m.end());
    judged.median_error_m = errors_m[errors_m.size() / 2];
  }
  // The way by the metre: was the robot here before, and is there a closure near?
  std::vector<std::pair<std::int64_t, SE3>> way;
  for (const auto& [utime_us, T] : truth_)
    if (way.empty() || (T.translation() - way.back().second.translation()).norm() >= kStep_m)
      way.emplace_back(utime_us, T);
  for (const auto& [utime_us, T] : way) {
    bool again = false;
    for (const auto& [before_us, T_before] : way) {
      const Vector6d apart = local(T_before, T);
      again = again || (utime_us - before_us >= options.again_us &&
                        apart.head<3>().norm() <= options.again_m &&
                        apart.tail<3>().norm() <= options.again_rad);
    }
    if (!again) continue;
    ++judged.revisits;
    for (const std::int64_t at : closed_at) {
      const auto there = truth_.lower_bound(at);
      if (there == truth_.end() || std::llabs(at - utime_us) > options.again_us / 2) continue;
      if ((there->second.translation() - T.translation()).norm() > options.recall_m) continue;
      ++judged.found;
      break;
    }
  }
  return judged;
}

std::string LoopReport::as_relations() const {
  std::string text;
  for (const Closure& closure : closures_) {
    const auto from = utime_of_.find(closure.from), to = utime_of_.find(closure.to);
    if (from == utime_of_.end() || to == utime_of_.end()) continue;
    const SE3 T = T_base_reference_.inverse() * closure.T_from_to * T_base_reference_;
    const Eigen::Matrix3d R = T.linear();
    text +=
        say("%.6f %.6f %.6f %.6f %.6f %.9f %.9f %.9f\n", 1e-6 * static_cast<double>(from->second),
            1e-6 * static_cast<double>(to->second), T.translation().x(), T.translation().y(),
            T.translation().z(), std::atan2(R(2, 1), R(2, 2)),
            std::asin(std::clamp(-R(2, 0), -1.0, 1.0)), std::atan2(R(1, 0), R(0, 0)));
  }
  return text;
}

std::string LoopReport::wrong_lines(const LoopReportOptions& options) const {
  std::string text;
  for (const Closure& closure : closures_) {
    const auto error = true_error(closure);
    if (!error || (error->head<3>().norm() <= options.wrong_m &&
                   error->tail<3>().norm() <= options.wrong_rad))
      continue;
    const bool off = std::any_of(switched_off_.begin(), switched_off_.end(), [&](const auto& s) {
      return node_id(s.from_kind, s.from_id) == closure.from &&
             node_id(s.to_kind, s.to_id) == closure.to;
    });
    text += say("wrong: %s - %s (%s), %.2f m and %.1f degrees beside the truth%s\n",
                name(closure.from).c_str(), name(closure.to).c_str(), closure.source.c_str(),
                error->head<3>().norm(), error->tail<3>().norm() * 180.0 / 3.14159265358979,
                off ? "; switched off again" : "");
  }
  return text;
}

std::string LoopReport::line(const loop_candidate_t& candidate) const {
  std::string text = say("%-8s %12.3f s  ", candidate.accepted != 0 ? "accepted" : "rejected",
                         1e-6 * static_cast<double>(candidate.utime));
  text += name(node_id(candidate.from_kind, candidate.from_id)) + " - " +
          name(node_id(candidate.to_kind, candidate.to_id)) + "\n";
  for (const stage_verdict_t& stage : candidate.stages)
    text += say("           %-12s %s  %.3g (%.3g)  ", stage.stage.c_str(),
                stage.passed != 0 ? "passed" : "   -  ", stage.score, stage.threshold) +
            stage.reason + "\n";
  return text;
}

std::string LoopReport::text(const LoopReportOptions& options) const {
  std::string text;
  std::size_t accepted = 0;
  std::map<std::string, std::size_t> stopped_by;  // the first stage asked that did not pass
  for (const loop_candidate_t& candidate : candidates_) {
    if (candidate.accepted != 0) {
      ++accepted;
    } else {
      std::string stage = "consistency";
      for (const stage_verdict_t& verdict : candidate.stages)
        if (verdict.passed == 0 && verdict.reason.rfind("not asked", 0) != 0 &&
            verdict.reason.rfind("the robot has no", 0) != 0) {
          stage = verdict.stage;
          break;
        }
      ++stopped_by[stage];
    }
    if (options.all || candidate.accepted != 0) text += line(candidate);
  }
  text += say("%zu candidates, %zu accepted", candidates_.size(), accepted);
  for (const auto& [stage, count] : stopped_by)
    text += say(", %zu stopped at %s", count, stage.c_str());
  std::map<std::string, std::size_t> by_source;
  for (const Closure& closure : closures_) ++by_source[closure.source];
  text += say("\n%zu constraints", closures_.size());
  for (const auto& [source, count] : by_source) text += say(", %zu %ss", count, source.c_str());
  text += say("; the graph took %ld and switched %zu off again\n", static_cast<long>(graph_loops_),
              switched_off_.size());
  for (const loop_state_t& loop : switched_off_)
    text += "switched off: " + name(node_id(loop.from_kind, loop.from_id)) + " - " +
            name(node_id(loop.to_kind, loop.to_id)) + ", " + loop.reason + "\n";
  if (const auto truth = judge(options)) {
    text +=
        say("against the ground truth: %zu of %zu constraints wrong (more than %.2f m or %.1f "
            "degrees), median error %.3f m\n",
            truth->wrong, truth->judged, options.wrong_m,
            options.wrong_rad * 180.0 / 3.14159265358979, truth->median_error_m);
    text += wrong_lines(options);
    text +=
        say("%zu m of the way led where the robot had been before, %zu m of them have a "
            "closure near\n",
            truth->revisits, truth->found);
  }
  return text;
}

}  // namespace fusion_slam
