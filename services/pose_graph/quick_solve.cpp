// Solves of the whole graph between two messages: a few steps from where the nodes are.
#include <algorithm>
#include <chrono>
#include <utility>

#include "libs/geometry/orthonormal.hpp"
#include "services/pose_graph/global_solve.hpp"
#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {
namespace {

std::int64_t rest_us(std::int64_t took_us, double share) {
  return static_cast<std::int64_t>(static_cast<double>(took_us) * (1.0 / share - 1.0));
}

}  // namespace

SolveOptions PoseGraph::quick_options(const std::set<NodeId>& moving) const {
  SolveOptions options;
  options.planar = robot_ && robot_->planar;
  options.anchor = by_time_.begin()->second;
  options.moving = moving;
  options.doubt = false;
  options.max_iterations = config_.quick_iterations;
  options.enough = config_.quick_enough;
  return options;
}

// A replay solves at once. Live not before the last such solve has been rested from, and elsewhere
// when that one was long: the graph grows, loops keep coming, and poses don't wait.
void PoseGraph::solve_quickly() {
  const bool live = !config_.wait_for_solver && !finishing_;
  quick_wanted_ = live && (quick_ || newest_utime_us_ < quick_rest_until_us_);
  if (quick_wanted_) return;
  if (live && quick_took_us_ > config_.longest_quick_us) return start_quick_solve();
  const auto began = std::chrono::steady_clock::now();
  solve({});
  if (!live) return;
  const auto took = std::chrono::steady_clock::now() - began;
  quick_took_us_ = std::chrono::duration_cast<std::chrono::microseconds>(took).count();
  quick_rest_until_us_ = newest_utime_us_ + rest_us(quick_took_us_, config_.quick_share);
}

void PoseGraph::start_quick_solve() {
  if (nodes_.empty()) return;
  GlobalSolve question;
  question.config = config_;
  question.options = quick_options({});
  question.nodes = nodes_;
  question.edges = edges_;
  unsolved_loops_ = 0;
  quick_ = std::make_unique<BackgroundSolve>();
  question.options.unwanted = quick_->unwanted;
  quick_->answer = solve_elsewhere(std::move(question));
}

// When it is there. Where loops stand in it counts only when the whole graph is solved anew.
void PoseGraph::meet_quick_solve() {
  if (!quick_ || quick_->answer.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    return;
  const SE3 T_now_then = quick_->T_now_then;
  const bool outdated = quick_->outdated;
  GlobalSolve answer = quick_->answer.get();
  quick_.reset();
  quick_took_us_ = answer.took_us;
  quick_rest_until_us_ = newest_utime_us_ + rest_us(quick_took_us_, config_.quick_share);
  if (outdated) quick_wanted_ = true;
  if (outdated || !answer.report.usable) return;
  for (auto& [id, node] : answer.nodes) node.T_map_base = orthonormal(T_now_then * node.T_map_base);
  ++counts_.solves;
  map_covariance_.clear();
  move_to(answer.nodes);
  const auto& errors = answer.report.loop_errors;
  if (std::any_of(errors.begin(), errors.end(),
                  [&](const auto& loop) { return loop.second > config_.loop_chi2; }))
    start_global_solve(false);
}

}  // namespace fusion_slam
