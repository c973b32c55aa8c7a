#include "logplayer/map_merge/join.hpp"

#include <algorithm>
#include <limits>

#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "libs/map_directory/decode.hpp"
#include "libs/messages/convert.hpp"
#include "libs/place_messages/place_messages.hpp"
#include "libs/schema/guard.hpp"
#include "services/localizer/load_localization_map.hpp"

namespace fusion_slam {
namespace {

constexpr double kApart_m = 0.5;
constexpr double kApart_rad = 0.5;
// Neighbouring fixes err together: the same map, the same walls.
constexpr double kErrTogether = 4.0;
constexpr double kFloor_m = 0.02;
constexpr double kFloor_rad = 0.01;

void feed(const LogEvent& event, Localizer* localizer) {
  std::string why;
  if (event.channel == "LIDAR_POSE") {
    const auto m = decode<pose_estimate_t>(event);
    const auto T = m ? from_message(m->T_frame_base) : std::nullopt;
    const bool good = m && (m->state == pose_estimate_t::OK || m->state == pose_estimate_t::WEAK);
    T&& good ? localizer->add_lidar_pose(m->utime, *T) : localizer->lidar_lost();
  } else if (event.channel == "LIDAR_NODE") {
    const auto m = decode<lidar_node_t>(event);
    const auto T = m ? from_message(m->T_odom_base) : std::nullopt;
    if (!T) return;
    if (auto points = points_from(*m, &why))
      localizer->add_scan({m->id, m->utime, *T, m->previous_id == 0, std::move(*points)});
  } else if (event.channel == "KEYFRAME") {
    const auto m = decode<keyframe_t>(event);
    const auto T = m ? from_message(m->T_odom_base) : std::nullopt;
    if (!T) return;
    if (auto features = features_from(*m, &why))
      localizer->add_view({m->id, m->utime, *T, m->previous_id == 0, std::move(*features)});
  }
}

}  // namespace

Join find_join(const MapReader& first, const MapState& first_state, const MapReader& second,
               const RobotModel& second_robot) {
  const LocalizationMap map = load_localization_map(first, first_state);
  Localizer localizer(map);
  localizer.set_sensors(second_robot.has_lidar, second_robot.has_camera);
  std::vector<std::pair<std::int64_t, LogEvent>> events;
  second.for_each([&](const LogEvent& event) {
    if (event.channel != "LIDAR_POSE" && event.channel != "LIDAR_NODE" &&
        event.channel != "KEYFRAME")
      return;
    const auto utime_us = peek_utime(event.data.data(), event.data.size());
    if (utime_us) events.emplace_back(*utime_us, event);
  });
  std::stable_sort(events.begin(), events.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  Join join;
  bool localized = false;
  for (const auto& [utime_us, event] : events) {
    feed(event, &localizer);
    const bool now = localizer.state() == LocalizationState::kLocalized;
    join.times_found += now && !localized ? 1 : 0;
    localized = now;
    for (MapFix& fix : localizer.take_fixes()) join.fixes.push_back(std::move(fix));
  }
  join.reason = localizer.reason();
  return join;
}

std::vector<CrossLoop> cross_loops(const std::vector<MapFix>& fixes,
                                   const std::map<NodeId, SE3>& T_map_nodes) {
  std::vector<CrossLoop> loops;
  std::optional<SE3> last;
  for (const MapFix& fix : fixes) {
    const SE3& T_map_base = fix.where.T_map_base;
    if (last && (last->translation() - T_map_base.translation()).norm() < kApart_m &&
        log_so3(last->linear().transpose() * T_map_base.linear()).norm() < kApart_rad)
      continue;
    auto from = T_map_nodes.find({NodeKind::kKeyframe, fix.map_keyframe});
    if (fix.node.kind == NodeKind::kLidar || from == T_map_nodes.end()) {
      double nearest = std::numeric_limits<double>::max();
      from = T_map_nodes.end();
      for (auto it = T_map_nodes.begin(); it != T_map_nodes.end(); ++it) {
        const double distance = (it->second.translation() - T_map_base.translation()).norm();
        if (it->first.kind != fix.node.kind || distance >= nearest) continue;
        nearest = distance;
        from = it;
      }
    }
    if (from == T_map_nodes.end()) continue;
    CrossLoop loop{from->first, fix.node, from->second.inverse() * T_map_base,
                   kErrTogether * fix.where.covariance};
    for (int axis = 0; axis < 6; ++axis) {
      const double floor = axis < 3 ? kFloor_m : kFloor_rad;
      loop.covariance(axis, axis) += floor * floor;
    }
    loops.push_back(loop);
    last = T_map_base;
  }
  return loops;
}

}  // namespace fusion_slam
