#include "libs/session/session_collector.hpp"

#include <algorithm>
#include <limits>

#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

// Counters are what other processes say: the sum stops at the largest number instead of wrapping,
// and a negative count is none.
std::int64_t add_count(std::int64_t total, std::int64_t count) {
  const std::int64_t room = std::numeric_limits<std::int64_t>::max() - total;
  return total + std::clamp<std::int64_t>(count, 0, room);
}

}  // namespace

void SessionCollector::begin_like(const SessionCollector& before) {
  robot_ = before.robot_;
  camera_model_ = before.camera_model_;
  statuses_ = before.statuses_;
}

void SessionCollector::on_robot_model(const robot_model_t& message) {
  std::string why;
  if (const auto robot = from_message(message, &why))
    robot_ = robot;
  else
    ++damaged_messages_;
}

void SessionCollector::on_camera_model(const camera_model_t& message) {
  std::string why;
  if (const auto model = from_message(message, &why))
    camera_model_ = model;
  else
    ++damaged_messages_;
}

void SessionCollector::on_camera(std::int64_t utime_us) {
  tracked_.camera_utimes_us.insert(utime_us);
}

void SessionCollector::on_lidar(std::int64_t utime_us) {
  tracked_.lidar_utimes_us.insert(utime_us);
}

void SessionCollector::on_ground_truth(const bot_core::pose_t& message) {
  if (const auto T = from_message(message))
    ground_truth_[message.utime] = *T;
  else
    ++damaged_messages_;
}

void SessionCollector::on_tracked(const pose_estimate_t& message,
                                  std::map<std::int64_t, TrackedPose>* poses) {
  TrackedPose pose;
  const auto T_reference_base = from_message(message.T_reference_base);
  pose.lost = message.state != pose_estimate_t::OK && message.state != pose_estimate_t::WEAK;
  if (message.reference_kind < 0 || message.reference_id <= 0) pose.lost = true;
  if (!pose.lost && !T_reference_base) {
    ++damaged_messages_;
    pose.lost = true;
  }
  if (!pose.lost) {
    pose.reference = {static_cast<NodeKind>(message.reference_kind), message.reference_id};
    pose.T_reference_base = *T_reference_base;
  }
  (*poses)[message.utime] = pose;
}

void SessionCollector::on_visual_pose(const pose_estimate_t& message) {
  on_tracked(message, &tracked_.visual);
}

void SessionCollector::on_lidar_pose(const pose_estimate_t& message) {
  on_tracked(message, &tracked_.lidar);
}

void SessionCollector::on_pose(const pose_estimate_t& message) {
  const auto T_map_base = from_message(message.T_frame_base);
  if (!T_map_base)
    ++damaged_messages_;
  else if (message.state == pose_estimate_t::OK || message.state == pose_estimate_t::WEAK)
    live_[message.utime] = *T_map_base;
  else
    ++live_lost_;
}

void SessionCollector::on_graph(const graph_t& message) { graph_.add(message); }

void SessionCollector::on_tile(const std::string& channel, const Tile& tile) {
  maps_.add(channel, tile);
}

void SessionCollector::on_tile(const std::string& channel, const tile_t& message) {
  maps_.add(channel, from_message(message));
}

void SessionCollector::on_status(const status_t& message) {
  status_t& held = statuses_[{message.process, message.pid}];
  if (held.seq <= message.seq) held = message;
}

std::int64_t SessionCollector::dropped_total() const {
  std::int64_t total = 0;
  for (const auto& [process, status] : statuses_)
    for (const channel_stats_t& channel : status.channels)
      total = add_count(total, channel.dropped);
  return total;
}

std::int64_t SessionCollector::lost_total() const {
  std::int64_t total = 0;
  for (const auto& [process, status] : statuses_)
    for (const channel_stats_t& channel : status.channels) total = add_count(total, channel.lost);
  return total;
}

}  // namespace fusion_slam
