#include "libs/session/final_trajectory.hpp"

#include "libs/geometry/timed_poses.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kMaxBridgeUs = 500'000;

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
    else if (const auto T_map_base = pose_at(scans, utime_us, kMaxBridgeUs))
      trajectory.push_back({utime_us, *T_map_base, true});
  }
  return trajectory;
}

}  // namespace fusion_slam
