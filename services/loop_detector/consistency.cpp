#include "services/loop_detector/consistency.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace fusion_slam {
namespace {

const LoopMeasurement& measured(const LoopCandidate& candidate) {
  return candidate.measurements.front();
}

double worst_sigma_m(const Matrix6d& covariance) {
  const Eigen::Matrix2d plane = covariance.topLeftCorner<2, 2>();
  return std::sqrt(std::max(
      0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(plane).eigenvalues().maxCoeff()));
}

void decide(LoopCandidate* candidate, int alike, int needed) {
  StageVerdict& verdict = candidate->stages.back();
  verdict.score = alike;
  verdict.threshold = needed;
  verdict.passed = alike >= needed;
  candidate->accepted = verdict.passed;
  char text[120];
  std::snprintf(text, sizeof text, "; %d of %d loops that must agree do", alike, needed);
  verdict.reason += text;
}

}  // namespace

double squared_distance(const Vector6d& error, const Matrix6d& covariance, bool planar) {
  if (!planar) return error.dot(covariance.ldlt().solve(error));
  const int index[3] = {0, 1, 5};
  Eigen::Vector3d e;
  Eigen::Matrix3d c;
  for (int i = 0; i < 3; ++i) {
    e[i] = error[index[i]];
    for (int j = 0; j < 3; ++j) c(i, j) = covariance(index[i], index[j]);
  }
  return e.dot(c.ldlt().solve(e));
}

Consistency::Gate Consistency::gate(const GraphKnowledge& graph,
                                    const LoopMeasurement& loop) const {
  Gate gate;
  gate.threshold = graph.planar() ? config_.gate_3d : config_.gate_6d;
  const auto known = graph.relative(loop.from, loop.to);
  if (!known) {
    gate.reason = "the graph does not know both nodes";
    return gate;
  }
  const Vector6d error = local(known->T_from_to, loop.T_from_to);
  gate.sigma_m = worst_sigma_m(known->covariance);
  gate.squared_distance =
      squared_distance(error, known->covariance + loop.covariance, graph.planar());
  gate.inside = gate.squared_distance <= gate.threshold;
  char text[160];
  std::snprintf(text, sizeof text,
                "%.2f m and %.1f degrees from where the graph has it (+- %.2f m)%s",
                error.head<3>().norm(), error.tail<3>().norm() * 180.0 / M_PI, gate.sigma_m,
                gate.inside ? "" : ": more than it can be wrong");
  gate.reason = text;
  return gate;
}

// Around the circle from_a -> to_a -> to_b -> from_b -> from_a nothing may be left over.
bool Consistency::agree(const GraphKnowledge& graph, const LoopCandidate& a,
                        const LoopCandidate& b) const {
  const LoopMeasurement& la = measured(a);
  const LoopMeasurement& lb = measured(b);
  const auto old_side = graph.relative(la.from, lb.from);
  const auto new_side = graph.relative(la.to, lb.to);
  if (!old_side || !new_side || !old_side->connected || !new_side->connected) return false;
  const SE3 by_b = old_side->T_from_to * lb.T_from_to * new_side->T_from_to.inverse();
  // All told in the axes of to_a.
  Matrix6d covariance = chained_covariance(old_side->covariance, lb.T_from_to, lb.covariance);
  covariance = chained_covariance(covariance, new_side->T_from_to.inverse(),
                                  inverse_covariance(new_side->covariance, new_side->T_from_to));
  covariance += la.covariance;
  return squared_distance(local(la.T_from_to, by_b), covariance, graph.planar()) <=
         (graph.planar() ? config_.pair_3d : config_.pair_6d);
}

// Two views from one place are one witness.
bool Consistency::apart(const GraphKnowledge& graph, const LoopCandidate& a,
                        const LoopCandidate& b) const {
  const auto T_map_a = graph.T_map_base(measured(a).to);
  const auto T_map_b = graph.T_map_base(measured(b).to);
  if (!T_map_a || !T_map_b) return false;
  const Vector6d step = local(*T_map_a, *T_map_b);
  return step.head<3>().norm() >= config_.apart_m || step.tail<3>().norm() >= config_.apart_rad;
}

std::vector<LoopCandidate> Consistency::judge(const GraphKnowledge& graph, LoopCandidate candidate,
                                              int alike) {
  // Those that agree with it, and, taken in order, with each other.
  std::vector<std::size_t> group;
  for (std::size_t i = 0; i < entries_.size() && alike > 1; ++i) {
    const LoopCandidate& other = entries_[i].candidate;
    if (!apart(graph, candidate, other) || !agree(graph, candidate, other)) continue;
    const bool with_all = std::all_of(group.begin(), group.end(), [&](std::size_t j) {
      const LoopCandidate& member = entries_[j].candidate;
      return apart(graph, other, member) && agree(graph, other, member);
    });
    if (with_all) group.push_back(i);
  }
  const int n = 1 + static_cast<int>(group.size());
  std::vector<LoopCandidate> decided;
  if (n >= alike) {
    for (const std::size_t i : group)  // the witnesses that waited are vouched for, too
      if (!entries_[i].accepted && n >= entries_[i].alike) {
        entries_[i].accepted = true;
        decide(&entries_[i].candidate, n, entries_[i].alike);
        decided.push_back(entries_[i].candidate);
      }
    decide(&candidate, n, alike);
    decided.push_back(candidate);
  }
  entries_.push_back({std::move(candidate), alike, n >= alike});
  while (entries_.size() > config_.most_waiting) {
    if (!entries_.front().accepted) {
      decide(&entries_.front().candidate, 1, std::max(2, entries_.front().alike));
      decided.push_back(entries_.front().candidate);
    }
    entries_.pop_front();
  }
  return decided;
}

std::vector<LoopCandidate> Consistency::expired(std::int64_t utime_us, bool all) {
  std::vector<LoopCandidate> decided;
  for (auto it = entries_.begin(); it != entries_.end();) {
    if (it->accepted || (!all && utime_us - it->candidate.utime_us < config_.wait_us)) {
      ++it;
      continue;
    }
    decide(&it->candidate, 1, std::max(2, it->alike));
    decided.push_back(it->candidate);
    it = entries_.erase(it);
  }
  return decided;
}

bool Consistency::is_about(const Entry& entry, const NodeId& id) {
  const auto& all = entry.candidate.measurements;
  return std::any_of(all.begin(), all.end(),
                     [&](const LoopMeasurement& m) { return m.from == id || m.to == id; });
}

bool Consistency::waits_for(const NodeId& id) const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [&](const Entry& e) { return !e.accepted && is_about(e, id); });
}

bool Consistency::mentions(const NodeId& id) const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [&](const Entry& e) { return is_about(e, id); });
}

void Consistency::forget(const NodeId& from, const NodeId& to) {
  const auto is_it = [&](const Entry& e) {
    for (const LoopMeasurement& m : e.candidate.measurements)
      if (m.from == from && m.to == to) return true;
    return false;
  };
  entries_.erase(std::remove_if(entries_.begin(), entries_.end(), is_it), entries_.end());
}

}  // namespace fusion_slam
