#include "services/lidar_mapper/lidar_mapper_process.hpp"

#include <limits>
#include <string>

#include "fusion_slam/graph_node_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kMostWaiting = 512;  // scans before the first ROBOT_MODEL: a minute and more
constexpr std::int64_t kOdometryIsDeadUs = 500'000;
constexpr std::int64_t kEverything = std::numeric_limits<std::int64_t>::max();

// Height, roll and pitch of a planar base are known to be 0; not exactly, so that the matrix can be
// inverted.
void planar_covariance(const Eigen::Matrix3d& planar, double* out) {
  Matrix6d full = Matrix6d::Identity() * 1e-6;
  const int index[3] = {0, 1, 5};
  for (int row = 0; row < 3; ++row)
    for (int col = 0; col < 3; ++col) full(index[row], index[col]) = planar(row, col);
  for (const int i : index) full(i, i) += 1e-8;
  to_message(full, out);
}

std::int8_t state_code(MatchState state) {
  switch (state) {
    case MatchState::kOk:
      return pose_estimate_t::OK;
    case MatchState::kWeak:
      return pose_estimate_t::WEAK;
    case MatchState::kLost:
      break;
  }
  return pose_estimate_t::LOST;
}

pose_estimate_t pose_message(const LidarPose& pose) {
  pose_estimate_t m{};
  m.utime = pose.utime_us;
  m.frame = "odom";
  m.T_frame_base = to_message(to_se3(pose.T_odom_base), pose.utime_us);
  planar_covariance(pose.covariance, m.covariance);
  m.state = state_code(pose.state);
  m.reason = pose.reason;
  m.reference_kind = graph_node_t::LIDAR;  // a pose without a node is never published
  m.reference_id = pose.reference_id;
  m.T_reference_base = to_message(to_se3(pose.T_reference_base), pose.utime_us);
  m.fix_utime = pose.fix_utime_us;
  m.n_matched = pose.n_matched;
  return m;
}

lidar_node_t node_message(const LidarNode& node) {
  lidar_node_t m{};
  m.utime = node.utime_us;
  m.id = node.id;
  m.T_odom_base = to_message(to_se3(node.T_odom_base), node.utime_us);
  m.previous_id = node.previous_id;
  m.T_previous_base = to_message(to_se3(node.T_previous_base), node.utime_us);
  planar_covariance(node.covariance, m.covariance);
  m.n_submaps = static_cast<std::int32_t>(node.submaps.size());
  for (const auto& membership : node.submaps) {
    m.submap_ids.push_back(membership.submap_id);
    m.T_submap_base.push_back(to_message(to_se3(membership.T_submap_base), node.utime_us));
  }
  m.n_points = static_cast<std::int32_t>(node.points_base.size());
  for (const auto& p : node.points_base) {
    m.x_m.push_back(static_cast<float>(p.x()));
    m.y_m.push_back(static_cast<float>(p.y()));
  }
  return m;
}

std::optional<LidarNode> node_from(const lidar_node_t& m) {
  const auto T_odom_base = from_message(m.T_odom_base);
  if (!T_odom_base) return std::nullopt;
  LidarNode node;
  node.id = m.id;
  node.utime_us = m.utime;
  node.T_odom_base = to_se2(*T_odom_base);
  node.previous_id = m.previous_id;
  for (std::size_t i = 0; i < m.submap_ids.size(); ++i)
    if (const auto T_submap_base = from_message(m.T_submap_base[i]))
      node.submaps.push_back({m.submap_ids[i], to_se2(*T_submap_base)});
  for (std::size_t i = 0; i < m.x_m.size(); ++i) node.points_base.emplace_back(m.x_m[i], m.y_m[i]);
  return node;
}

}  // namespace

LidarMapperProcess::LidarMapperProcess(Bus& bus)
    : bus_(bus), ids_(bus), submap_tiles_(bus, "SUBMAP") {
  bus_.subscribe<robot_model_t>("ROBOT_MODEL", Policy::kLatestOnly,
                                [this](const robot_model_t& m) { on_robot_model(m); });
  bus_.subscribe<bot_core::planar_lidar_t>(
      "LIDAR", Policy::kKeepAll, [this](const bot_core::planar_lidar_t& m) { on_scan(m); });
  bus_.subscribe<bot_core::pose_t>("ODOMETRY", Policy::kKeepAll,
                                   [this](const bot_core::pose_t& m) { on_odometry(m); });
  bus_.subscribe<pose_estimate_t>("VISUAL_POSE", Policy::kKeepAll,
                                  [this](const pose_estimate_t& m) { on_visual_pose(m); });
  bus_.subscribe<command_t>("COMMAND", Policy::kKeepAll,
                            [this](const command_t& m) { on_command(m); });
  bus_.keep_in_journal({"ROBOT_MODEL"});
  // Nodes carry their scans, so they rebuild the active submaps; finished ones are their tiles.
  bus_.keep_said<lidar_node_t>("LIDAR_NODE", [this](const lidar_node_t& m) { on_earlier_node(m); });
  bus_.keep_said<tile_t>("SUBMAP", [](const tile_t&) {});
  say_state();
}

void LidarMapperProcess::on_earlier_node(const lidar_node_t& message) {
  auto node = node_from(message);
  if (!node) return;
  ids_.said(node->id);
  if (node->previous_id == 0) earlier_.clear();  // a map of its own
  earlier_.push_back(std::move(*node));
  while (earlier_.size() > static_cast<std::size_t>(LidarMapper::nodes_to_resume()))
    earlier_.pop_front();
}

void LidarMapperProcess::on_robot_model(const robot_model_t& message) {
  if (mapper_) return;  // a robot doesn't change while it drives
  std::string why;
  const auto robot = from_message(message, &why);
  if (!robot) return bus_.report_error("ROBOT_MODEL is not usable: " + why);
  if (!robot->has_lidar) return bus_.set_state_text("this robot has no LiDAR");
  mapper_.emplace(*robot);
  publish(mapper_->resume({earlier_.begin(), earlier_.end()}, ids_.next()));
  earlier_.clear();
  if (!waiting_.empty()) handle_scans(waiting_.back().utime_us);
  say_state();
}

void LidarMapperProcess::on_scan(const bot_core::planar_lidar_t& message) {
  std::string why;
  auto scan = from_message(message, &why);
  if (!scan) return bus_.report_error("LIDAR scan dropped: " + why);
  reset_.passes(scan->utime_us);
  if (mapper_) handle_scans(kEverything);  // no scan waits longer than for the next one
  waiting_.push_back(std::move(*scan));
  if (waiting_.size() > kMostWaiting) {
    waiting_.pop_front();
    if (++dropped_waiting_ == 1)
      bus_.report_error("scans are dropped until the first ROBOT_MODEL comes");
  }
  if (mapper_ && !odometry_is_coming(message.utime)) handle_scans(kEverything);
}

// Odometry that is alive but older than the scan will pass it soon: then the motion need not be
// extrapolated.
bool LidarMapperProcess::odometry_is_coming(std::int64_t utime_us) const {
  return newest_odometry_us_ && *newest_odometry_us_ < utime_us &&
         utime_us - *newest_odometry_us_ < kOdometryIsDeadUs;
}

void LidarMapperProcess::on_odometry(const bot_core::pose_t& message) {
  const auto T_odom_base = from_message(message);
  if (!T_odom_base) return bus_.report_error("ODOMETRY is not a rigid motion");
  newest_odometry_us_ = message.utime;
  if (!mapper_) return;
  mapper_->add_odometry(message.utime, to_se2(*T_odom_base));
  handle_scans(message.utime);
}

void LidarMapperProcess::on_visual_pose(const pose_estimate_t& message) {
  if (!mapper_) return;
  const auto T_odom_base = from_message(message.T_frame_base);
  const bool reliable = T_odom_base && message.state == pose_estimate_t::OK;
  mapper_->add_visual_pose(message.utime, reliable ? to_se2(*T_odom_base) : SE2{}, reliable);
}

void LidarMapperProcess::on_command(const command_t& message) {
  if (reset_.asks(message) && mapper_) {
    mapper_->reset();
    submap_tiles_.clear();
    return say_state();
  }
  const bool for_us = message.target.empty() || message.target == "lidar_mapper";
  if (!for_us || message.verb != "finish" || !mapper_) return;
  handle_scans(kEverything);
  publish(mapper_->finish());
  say_state();
}

void LidarMapperProcess::handle_scans(std::int64_t utime_us) {
  bool handled = false;
  while (!waiting_.empty() && waiting_.front().utime_us <= utime_us) {
    publish(mapper_->add_scan(waiting_.front()));
    waiting_.pop_front();
    handled = true;
  }
  if (handled && mapper_->counts().scans % 32 == 0) say_state();
}

void LidarMapperProcess::publish(const MapperOutput& output) {
  if (output.node) bus_.publish("LIDAR_NODE", node_message(*output.node));
  if (output.pose) bus_.publish("LIDAR_POSE", pose_message(*output.pose));
  publish(output.tiles);
}

void LidarMapperProcess::publish(const std::vector<Tile>& tiles) {
  for (const Tile& tile : tiles) submap_tiles_.publish(tile);
}

void LidarMapperProcess::say_state() {
  if (!mapper_) return bus_.set_state_text("waiting for ROBOT_MODEL");
  const MapperCounts& c = mapper_->counts();
  bus_.set_state_text(std::to_string(c.scans) + " scans, " + std::to_string(c.nodes) + " nodes, " +
                      std::to_string(c.weak) + " weak, " + std::to_string(c.lost) + " lost, " +
                      std::to_string(c.restarts) + " restarts, " + std::to_string(c.segments) +
                      " segments after silence, " + std::to_string(c.duplicates) + " repeated, " +
                      std::to_string(c.doubtful_stamps) + " doubtful stamps, " +
                      std::to_string(c.unusable) + " too empty");
}

}  // namespace fusion_slam
