#include "viz/web/truth_view.hpp"

#include <algorithm>
#include <cmath>

#include "libs/evaluation/alignment.hpp"
#include "viz/web/protocol.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kMostGap_us = 1'000'000;
constexpr std::size_t kMostPairs = 2000;

}  // namespace

void TruthView::on_truth(std::int64_t utime_us, const SE3& T_truth_base) {
  poses_[utime_us] = T_truth_base;
  const Eigen::Vector3f p = T_truth_base.translation().cast<float>();
  if (!drawn_.empty() && (p - drawn_.back()).norm() < kStep_m) return;
  drawn_.push_back(p);
  const std::size_t chunk = (drawn_.size() - 1) / kChunkPoints;
  // The first point of a chunk repeats the last one of the chunk before, so that the line has no
  // gap.
  ByteWriter out;
  for (std::size_t i = chunk == 0 ? 0 : chunk * kChunkPoints - 1; i < drawn_.size(); ++i)
    out.f32(drawn_[i].x()).f32(drawn_[i].y()).f32(drawn_[i].z());
  store_.put(Topic::kTruth, std::to_string(chunk), out.take());
}

std::optional<SE3> TruthView::at(std::int64_t utime_us) const {
  return pose_at(poses_, utime_us, kMostGap_us);
}

std::optional<SE3> TruthView::newest() const {
  if (poses_.empty()) return std::nullopt;
  return T_map_truth_ * poses_.rbegin()->second;
}

void TruthView::align(const std::map<NodeId, GraphView::Node>& nodes) {
  if (poses_.empty()) return;
  std::vector<Eigen::Vector3d> truth;
  std::vector<Eigen::Vector3d> estimate;
  std::optional<SE3> T_origin;
  const std::size_t stride = nodes.size() / kMostPairs + 1;
  std::size_t n = 0;
  for (const auto& [id, node] : nodes) {
    if (n++ % stride != 0 || !node.T_map_base) continue;
    const auto T_truth_base = at(node.utime_us);
    if (!T_truth_base) continue;
    if (!T_origin) T_origin = *node.T_map_base * T_truth_base->inverse();
    truth.push_back(T_truth_base->translation());
    estimate.push_back(node.T_map_base->translation());
  }
  if (!T_origin) return;
  const auto best = umeyama(truth, estimate, false);
  // Too few or all on a line: then the first node decides.
  T_map_truth_ = best ? best->T_to_from : *T_origin;
  double squares_m2 = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    squares_m2 += (T_map_truth_ * truth[i] - estimate[i]).squaredNorm();
  const Eigen::Quaterniond q(T_map_truth_.linear());
  const Eigen::Vector3d t = T_map_truth_.translation();
  store_.put(Topic::kTruth, "alignment",
             to_text({{"t", {t.x(), t.y(), t.z()}},
                      {"q", {q.w(), q.x(), q.y(), q.z()}},
                      {"pairs", truth.size()},
                      {"rmse_m", std::sqrt(squares_m2 / static_cast<double>(truth.size()))}}));
}

void TruthView::clear() {
  poses_.clear();
  drawn_.clear();
  T_map_truth_ = SE3::Identity();
  store_.remove_all(Topic::kTruth);
}

}  // namespace fusion_slam
