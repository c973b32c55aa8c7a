#include "libs/evaluation/relations.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "libs/evaluation/association.hpp"
#include "libs/evaluation/pose_error.hpp"

namespace fusion_slam {
namespace {

constexpr char kColumns[] = "t1 t2 x y z roll pitch yaw";

std::vector<PoseRelation> to_relations(const std::vector<NumberRow>& rows) {
  std::vector<PoseRelation> relations;
  relations.reserve(rows.size());
  for (const NumberRow& row : rows) {
    const auto& v = row.values;
    relations.push_back({v[0], v[1], from_xyz_rpy(v[2], v[3], v[4], v[5], v[6], v[7])});
  }
  return relations;
}

std::string explain_none_usable(const std::vector<PoseRelation>& relations,
                                const Trajectory& estimate, double offset_s) {
  if (relations.empty()) return "there are no relations";
  if (estimate.empty()) return "the estimate has no poses";
  double first_s = relations.front().time_1_s;
  double last_s = first_s;
  for (const PoseRelation& relation : relations) {
    first_s = std::min({first_s, relation.time_1_s, relation.time_2_s});
    last_s = std::max({last_s, relation.time_1_s, relation.time_2_s});
  }
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(),
                "none of the %zu relations is usable: they span %.3f s to %.3f s, the estimate "
                "with its offset "
                "%.3f s to %.3f s; set --time-offset",
                relations.size(), first_s, last_s, estimate.front().time_s + offset_s,
                estimate.back().time_s + offset_s);
  return text.data();
}

}  // namespace

std::vector<PoseRelation> read_relations(const std::filesystem::path& file) {
  return to_relations(read_number_rows(file, kColumns));
}

std::vector<PoseRelation> read_relations(std::istream& in, const std::string& name) {
  return to_relations(read_number_rows(in, name, kColumns));
}

double RelationsError::usable_percent() const {
  return total == 0 ? 0.0 : 100.0 * static_cast<double>(usable) / static_cast<double>(total);
}

std::optional<SE3> pose_at(const Trajectory& trajectory, double time_s,
                           const RelationsOptions& options) {
  if (trajectory.empty()) return std::nullopt;
  const StampedPose& nearest = trajectory[nearest_in_time(trajectory, time_s)];
  if (nearest.time_s == time_s) return nearest.T_world_body;
  const auto after = std::upper_bound(trajectory.begin(), trajectory.end(), time_s,
                                      [](double t, const StampedPose& p) { return t < p.time_s; });
  if (after == trajectory.begin() || after == trajectory.end()) return std::nullopt;
  const StampedPose& a = *std::prev(after);
  const StampedPose& b = *after;
  const double gap_s = b.time_s - a.time_s;  // above 0: a is before time_s, b after it
  if (gap_s > options.max_gap_s) return std::nullopt;
  if (options.nearest) return nearest.T_world_body;
  return interpolate(a.T_world_body, b.T_world_body, (time_s - a.time_s) / gap_s);
}

Outcome<RelationsError> evaluate_relations(const std::vector<PoseRelation>& relations,
                                           const Trajectory& estimate,
                                           const RelationsOptions& options) {
  std::vector<double> translations_m;
  std::vector<double> rotations_deg;
  for (const PoseRelation& relation : relations) {
    const auto T1 = pose_at(estimate, relation.time_1_s - options.time_offset_s, options);
    const auto T2 = pose_at(estimate, relation.time_2_s - options.time_offset_s, options);
    if (!T1 || !T2) continue;
    const SE3 E = relation.T_1_2.inverse() * (T1->inverse() * *T2);
    translations_m.push_back(pose_error(E, ErrorRelation::kTranslation));
    rotations_deg.push_back(pose_error(E, ErrorRelation::kRotation));
  }
  if (translations_m.empty()) {
    return Outcome<RelationsError>::failure(
        explain_none_usable(relations, estimate, options.time_offset_s));
  }
  RelationsError result;
  result.translation_m = compute_statistics(translations_m);
  result.rotation_deg = compute_statistics(rotations_deg);
  result.usable = translations_m.size();
  result.total = relations.size();
  return Outcome<RelationsError>::success(result);
}

}  // namespace fusion_slam
