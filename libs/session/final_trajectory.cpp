#include "libs/session/final_trajectory.hpp"

#include <iterator>

namespace fusion_slam {
namespace {

constexpr std::uint64_t kMaxBridgeUs = 500'000;

std::optional<SE3> in_map(const TrackedSession& session, const TrackedPose& pose) {
  const auto node = session.T_map_nodes.find(pose.reference);
  if (pose.lost || node == session.T_map_nodes.end()) return std::nullopt;
  return node->second * pose.T_reference_base;
}

std::map<std::int64_t, SE3> all_in_map(const TrackedSession& session,
                                       const std::map<std::int64_t, TrackedPose>& poses) {
  std::map<std::int64_t, SE3> result;
  for (const auto& [utime_us, pose] : poses)
    if (const auto T_map_base = in_map(session, pose)) result.emplace(utime_us, *T_map_base);
  return result;
}

std::optional<SE3> between(const std::map<std::int64_t, SE3>& scans, std::int64_t utime_us) {
  const auto after = scans.lower_bound(utime_us);
  if (after == scans.end()) return std::nullopt;
  if (after->first == utime_us) return after->second;
  if (after == scans.begin()) return std::nullopt;
  const auto before = std::prev(after);
  // Unsigned: times of hostile messages may be further apart than an int64 can say.
  const std::uint64_t start_us = static_cast<std::uint64_t>(before->first);
  const std::uint64_t gap_us = static_cast<std::uint64_t>(after->first) - start_us;
  if (gap_us > kMaxBridgeUs) return std::nullopt;
  const std::uint64_t since_us = static_cast<std::uint64_t>(utime_us) - start_us;
  return interpolate(before->second, after->second,
                     static_cast<double>(since_us) / static_cast<double>(gap_us));
}

}  // namespace

std::vector<FinalPose> final_trajectory(const TrackedSession& session) {
  std::vector<FinalPose> trajectory;
  const auto scans = all_in_map(session, session.lidar);
  if (!session.has_camera()) {
    for (const auto& [utime_us, T_map_base] : scans)
      trajectory.push_back({utime_us, T_map_base, false});
    return trajectory;
  }
  const auto frames = all_in_map(session, session.visual);
  std::set<std::int64_t> utimes_us = session.camera_utimes_us;
  for (const auto& [utime_us, pose] : session.visual) utimes_us.insert(utime_us);
  for (const std::int64_t utime_us : utimes_us) {
    const auto frame = frames.find(utime_us);
    if (frame != frames.end())
      trajectory.push_back({utime_us, frame->second, false});
    else if (const auto T_map_base = between(scans, utime_us))
      trajectory.push_back({utime_us, *T_map_base, true});
  }
  return trajectory;
}

}  // namespace fusion_slam
