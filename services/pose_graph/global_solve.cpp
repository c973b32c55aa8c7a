// Where the pose graph meets the thread that solves it anew, and what becomes of loops that do not
// fit.
#include "services/pose_graph/global_solve.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <utility>

#include "libs/geometry/orthonormal.hpp"
#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {

std::future<GlobalSolve> solve_elsewhere(GlobalSolve question) {
  return std::async(std::launch::async, [question = std::move(question)]() mutable {
    if (question.config.solver_begins) question.config.solver_begins();
    const auto began = std::chrono::steady_clock::now();
    question.report =
        solve_graph(question.config, question.options, &question.nodes, &question.edges);
    if (question.bundle)
      question.bundle_report = adjust_globally(question.config, question.options, *question.bundle,
                                               &question.nodes, &question.edges);
    question.took_us = std::chrono::duration_cast<std::chrono::microseconds>(
                           std::chrono::steady_clock::now() - began)
                           .count();
    return std::move(question);
  });
}

// Something of the camera's has closed since the last bundle adjustment, and the graph has grown so
// much that one is worth while: all of them together cost a few times the last one.
bool PoseGraph::bundle_is_due() const {
  return camera_ && robot_ && new_visual_loops_ > 0 &&
         static_cast<double>(seen_.n_keyframes()) >=
             config_.bundle.growth * static_cast<double>(bundled_keyframes_);
}

std::shared_ptr<const BundleQuestion> PoseGraph::bundle_question() {
  auto question = std::make_shared<BundleQuestion>();
  question->camera = *camera_;
  question->T_base_camera = robot_->T_base_camera;
  question->seen = seen_;
  for (const GraphEdge& edge : edges_) {
    if (edge.kind != EdgeKind::kLoop || edge.loop_weight < 0.5) continue;
    const auto same = same_points_.find({edge.from, edge.to});
    if (edge.said_from.id == 0 && same != same_points_.end())
      question->same.push_back({edge.from.id, edge.to.id, same->second});
  }
  bundled_keyframes_ = seen_.n_keyframes();
  new_visual_loops_ = 0;
  return question;
}

// Live a new one begins when the last one has been rested from, so that the solver has its share
// of a core and no more, however many loops keep coming.
void PoseGraph::start_global_solve(bool with_bundle) {
  if (background_ || nodes_.empty()) return;
  solve_wanted_ = newest_utime_us_ < rest_until_us_ && !finishing_;
  if (solve_wanted_) return;
  GlobalSolve question;
  if (with_bundle) question.bundle = bundle_question();
  question.config = config_;
  question.options.planar = robot_ && robot_->planar;
  question.options.anchor = by_time_.begin()->second;
  question.nodes = nodes_;
  question.edges = edges_;
  background_ = std::make_unique<BackgroundSolve>();
  question.options.unwanted = background_->unwanted;
  background_->meet_us =
      newest_utime_us_ + (with_bundle ? config_.bundle.meet_after_us : config_.meet_after_us);
  background_->answer = solve_elsewhere(std::move(question));
}

// Not before the meeting point. There a replay waits for the answer, so what happens does not
// depend on how fast the thread was; on a robot poses go on without it.
void PoseGraph::meet_global_solve(bool now) {
  if (!background_) return;
  if (!now && newest_utime_us_ < background_->meet_us) return;
  if (!now && !config_.wait_for_solver &&
      background_->answer.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    return;
  GlobalSolve answer = background_->answer.get();
  for (auto& [id, node] : answer.nodes)
    node.T_map_base = orthonormal(background_->T_now_then * node.T_map_base);
  background_.reset();
  if (!config_.wait_for_solver)
    rest_until_us_ =
        newest_utime_us_ + static_cast<std::int64_t>(static_cast<double>(answer.took_us) *
                                                     (1.0 / config_.solver_share - 1.0));
  const std::size_t asked = answer.edges.size();
  const bool pulls =
      std::any_of(edges_.begin() + static_cast<std::ptrdiff_t>(asked), edges_.end(),
                  [](const GraphEdge& edge) { return edge.kind == EdgeKind::kLoop; });
  adopt(answer);
  thin();  // before the next solve is asked for: while loops keep coming one follows the other
  if (quick_) *quick_->unwanted = quick_->outdated = true;
  if (!pulls) return;
  quick_rest_until_us_ = 0;
  solve_quickly();  // the answer knows nothing of loops that came since
}

// Nodes that came since then move along with the newest one of their kind that was there; some have
// been retired since.
void PoseGraph::move_to(const GraphNodes& solved) {
  std::map<NodeId, SE3> correction;  // T_new_old of the map at a node
  for (const auto& [id, node] : solved)
    if (const auto now = nodes_.find(id); now != nodes_.end())
      correction[id] = node.T_map_base * now->second.T_map_base.inverse();
  for (auto& [id, node] : nodes_) {
    changed_.insert(id);
    const auto found = solved.find(id);
    if (found != solved.end()) {
      node.T_map_base = found->second.T_map_base;
      continue;
    }
    auto before = correction.lower_bound(id);
    const bool same_kind = before != correction.begin() && std::prev(before)->first.kind == id.kind;
    if (same_kind)
      node.T_map_base = orthonormal(std::prev(before)->second * node.T_map_base);
    else if (!correction.empty())
      node.T_map_base = orthonormal(correction.rbegin()->second * node.T_map_base);
  }
}

void PoseGraph::adopt(const GlobalSolve& answer) {
  ++counts_.solves;
  map_covariance_.clear();
  if (!answer.report.usable) return;
  move_to(answer.nodes);
  for (std::size_t i = 0; i < answer.edges.size(); ++i) {
    edges_[i].loop_weight = answer.edges[i].loop_weight;
    const bool as_asked = edges_[i].T_from_to.matrix() == answer.edges[i].T_from_to.matrix();
    if (answer.bundle_report.accepted && as_asked) edges_[i].adjusted = answer.edges[i].adjusted;
  }
  if (answer.bundle) {
    ++(answer.bundle_report.accepted ? counts_.bundles : counts_.bundles_refused);
    last_bundle_ = answer.bundle_report;
  }
  counts_.loops_outvoted = answer.report.loops_outvoted;
  for (const auto& [edge, error] : answer.report.loop_errors) {
    if (edges_[edge].loop_weight < 0.1)
      ++doubted_[edge];
    else
      doubted_.erase(edge);
  }
  judge_loops();
}

// A loop that the graph outvotes again and again is taken out of it, and said so.
void PoseGraph::judge_loops() {
  std::vector<std::size_t> off;
  for (const auto& [edge, times] : doubted_)
    if (times >= config_.switch_off_after) off.push_back(edge);
  if (off.empty()) return;
  const bool planar = robot_ && robot_->planar;
  for (const std::size_t i : off) {
    const GraphEdge& edge = edges_[i];
    LoopState state;
    const bool as_said = edge.said_from.id == 0;
    state.from = as_said ? edge.from : edge.said_from;
    state.to = as_said ? edge.to : edge.said_to;
    state.squared_error = edge_error(config_, planar, nodes_, edge);
    const Vector6d error = local(
        edge.T_from_to, nodes_.at(edge.from).T_map_base.inverse() * nodes_.at(edge.to).T_map_base);
    char text[160];
    std::snprintf(text, sizeof text,
                  "%.2f m and %.1f degrees from what all other edges say, after %d solves",
                  error.head<3>().norm(), error.tail<3>().norm() * 180.0 / 3.14159265358979,
                  config_.switch_off_after);
    state.reason = text;
    switched_off_.push_back(state);
    same_points_.erase({state.from, state.to});
    ++counts_.loops_switched_off;
  }
  for (auto i = off.rbegin(); i != off.rend(); ++i)
    edges_.erase(edges_.begin() + static_cast<std::ptrdiff_t>(*i));
  doubted_.clear();  // edges have new numbers; those still in doubt are seen again
}

}  // namespace fusion_slam
