#include "services/localizer/localizer_process.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "fusion_slam/graph_t.hpp"
#include "libs/messages/convert.hpp"
#include "libs/place_messages/place_messages.hpp"
#include "services/localizer/load_localization_map.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kNodesPerPart = 400;  // 81 bytes each: one datagram
constexpr double kSameCamera = 0.02;        // relative difference of focal lengths

graph_node_t node_message(const NodeId& id, const PlacedNode& node) {
  graph_node_t message{};
  message.kind = static_cast<std::int8_t>(id.kind);
  message.id = id.id;
  message.utime = node.utime_us;
  message.T_map_base = to_message(node.T_map_base, node.utime_us);
  return message;
}

bool is_lost(const pose_estimate_t& pose) {
  return pose.state != pose_estimate_t::OK && pose.state != pose_estimate_t::WEAK;
}

}  // namespace

const char* name_of(LocalizationState state) {
  switch (state) {
    case LocalizationState::kCandidate:
      return "CANDIDATE";
    case LocalizationState::kLocalized:
      return "LOCALIZED";
    case LocalizationState::kUnknown:
      break;
  }
  return "UNKNOWN";
}

std::int8_t pose_state_of(LocalizationState state) {
  switch (state) {
    case LocalizationState::kCandidate:
      return pose_estimate_t::WEAK;
    case LocalizationState::kLocalized:
      return pose_estimate_t::OK;
    case LocalizationState::kUnknown:
      break;
  }
  return pose_estimate_t::UNKNOWN;
}

LocalizerProcess::LocalizerProcess(Bus& bus, const std::filesystem::path& map_directory)
    : bus_(bus),
      reader_(map_directory),
      state_(read_state(reader_)),
      map_(load_localization_map(reader_, state_)),
      localizer_(map_) {
  bus.subscribe<lidar_node_t>("LIDAR_NODE", Policy::kKeepAll,
                              [this](const lidar_node_t& m) { on_lidar_node(m); });
  bus.subscribe<keyframe_t>("KEYFRAME", Policy::kKeepAll,
                            [this](const keyframe_t& m) { on_keyframe(m); });
  bus.subscribe<pose_estimate_t>("LIDAR_POSE", Policy::kKeepAll, [this](const pose_estimate_t& m) {
    on_pose(NodeKind::kLidar, m);
  });
  bus.subscribe<pose_estimate_t>("VISUAL_POSE", Policy::kKeepAll, [this](const pose_estimate_t& m) {
    on_pose(NodeKind::kKeyframe, m);
  });
  bus.subscribe<robot_model_t>("ROBOT_MODEL", Policy::kLatestOnly,
                               [this](const robot_model_t& m) { on_robot_model(m); });
  bus.subscribe<camera_model_t>("CAMERA_MODEL", Policy::kLatestOnly,
                                [this](const camera_model_t& m) { on_camera_model(m); });
  bus.subscribe<command_t>("COMMAND", Policy::kKeepAll,
                           [this](const command_t& m) { on_command(m); });
  // A tracker says its node before the pose of the same time; POSE must not wait for the slower
  // sensor.
  bus.never_await({"KEYFRAME", "LIDAR_NODE", "VISUAL_POSE", "LIDAR_POSE", "COMMAND"});
  if (bus.mode() == Mode::kLive)  // for who listens late
    bus.every(1000, [this] {
      publish_all_nodes();
      publish_localization(newest_us_);
    });
  MapPublisher(bus_, state_).say_tiles();  // the map is seen at once
  publish_localization(0);
}

void LocalizerProcess::on_lidar_node(const lidar_node_t& message) {
  std::string why;
  const auto T_odom_base = from_message(message.T_odom_base);
  auto points = points_from(message, &why);
  if (!T_odom_base || !points)
    return bus_.report_error("LIDAR_NODE refused: " +
                             (points ? std::string("T_odom_base is not a rigid motion") : why));
  localizer_.add_scan(
      {message.id, message.utime, *T_odom_base, message.previous_id == 0, std::move(*points)});
  publish_news(message.utime);
}

void LocalizerProcess::on_keyframe(const keyframe_t& message) {
  std::string why;
  const auto T_odom_base = from_message(message.T_odom_base);
  auto features = features_from(message, &why);
  if (!T_odom_base || !features)
    return bus_.report_error("KEYFRAME refused: " +
                             (features ? std::string("T_odom_base is not a rigid motion") : why));
  localizer_.add_view(
      {message.id, message.utime, *T_odom_base, message.previous_id == 0, std::move(*features)});
  publish_news(message.utime);
}

void LocalizerProcess::on_pose(NodeKind sensor, const pose_estimate_t& message) {
  if (sensor == NodeKind::kLidar) {
    const auto T_odom_base = from_message(message.T_frame_base);
    if (is_lost(message) || !T_odom_base)
      localizer_.lidar_lost();
    else
      localizer_.add_lidar_pose(message.utime, *T_odom_base);
    publish_news(message.utime);
  }
  publish_pose(message);
}

// POSE at the sensors' rate: where the node that a pose hangs on lies in the map, and the way
// since.
void LocalizerProcess::publish_pose(const pose_estimate_t& message) {
  pose_estimate_t pose = message;
  pose.frame = "map";
  if (localizer_.state() == LocalizationState::kLocalized && !is_lost(message)) {
    const NodeId reference{static_cast<NodeKind>(message.reference_kind), message.reference_id};
    const auto placed = localizer_.placed().find(reference);
    const auto T_reference_base = from_message(message.T_reference_base);
    if (placed == localizer_.placed().end() || !T_reference_base) return;  // its node comes soon
    pose.T_frame_base = to_message(placed->second.T_map_base * *T_reference_base, message.utime);
    const Matrix6d covariance =
        placed->second.covariance + covariance_from_message(message.covariance);
    to_message(covariance, pose.covariance);
  } else {
    pose.state = is_lost(message) ? pose_estimate_t::LOST : pose_estimate_t::UNKNOWN;
    pose.T_frame_base = to_message(SE3::Identity(), message.utime);
    pose.reason = std::string(name_of(localizer_.state())) + ": " + localizer_.reason();
  }
  bus_.publish("POSE", pose);
}

void LocalizerProcess::on_robot_model(const robot_model_t& message) {
  localizer_.set_sensors(message.has_lidar != 0, message.has_camera != 0);
}

void LocalizerProcess::on_camera_model(const camera_model_t& message) {
  if (camera_checked_ || !map_.camera()) return;
  camera_checked_ = true;
  const CameraModel& of_map = *map_.camera();
  const bool same = std::abs(message.fx / of_map.fx_px - 1.0) < kSameCamera &&
                    std::abs(message.fy / of_map.fy_px - 1.0) < kSameCamera &&
                    message.width == of_map.width_px && message.height == of_map.height_px;
  if (!same)
    bus_.report_error(
        "the map was made with another camera (its focal length or size differ): views will not "
        "be known again as well");
}

void LocalizerProcess::on_command(const command_t& message) {
  if (!message.target.empty() && message.target != "localizer") return;
  if (message.verb == "finish") publish_all_nodes();
  if (message.verb == "reset") localizer_.start_anew();
  if (message.verb == "localise") {  // argument: x y (m) yaw (rad) in the map
    std::istringstream numbers(message.argument);
    SE2 T_map_base;
    std::string why = "expected x y yaw";
    if (!(numbers >> T_map_base.x >> T_map_base.y >> T_map_base.yaw) ||
        !localizer_.hint(T_map_base, &why))
      bus_.report_error("COMMAND localise " + message.argument + ": " + why);
  }
  if (message.verb == "reset" || message.verb == "localise") publish_news(newest_us_);
}

void LocalizerProcess::publish_news(std::int64_t utime_us) {
  newest_us_ = std::max(newest_us_, utime_us);
  localizer_.take_fixes();
  std::vector<graph_node_t> nodes;
  for (const auto& [id, node] : localizer_.take_placed()) nodes.push_back(node_message(id, node));
  if (!nodes.empty()) {
    ++revision_;
    publish_graph(nodes, false);
  }
  const std::string now = std::string(name_of(localizer_.state())) + ": " + localizer_.reason();
  if (now == said_ && nodes.empty()) return;
  publish_localization(utime_us);
}

void LocalizerProcess::publish_localization(std::int64_t utime_us) {
  said_ = std::string(name_of(localizer_.state())) + ": " + localizer_.reason();
  pose_estimate_t message{};
  message.utime = utime_us;
  message.frame = "map";
  message.state = pose_state_of(localizer_.state());
  message.reason = said_;
  message.reference_kind = -1;
  const PlacedNode here = localizer_.here().value_or(PlacedNode{});
  message.T_frame_base = to_message(here.T_map_base, utime_us);
  message.T_reference_base = to_message(SE3::Identity(), utime_us);
  to_message(here.covariance, message.covariance);
  message.fix_utime = localizer_.localized_utime_us();
  message.n_matched = static_cast<std::int32_t>(std::lround(100.0 * localizer_.score()));
  bus_.publish("LOCALIZATION", message);
  bus_.set_state_text(said_);
}

void LocalizerProcess::publish_all_nodes() {
  std::vector<graph_node_t> nodes;
  for (const auto& [id, node] : localizer_.placed()) nodes.push_back(node_message(id, node));
  if (!nodes.empty()) publish_graph(nodes, true);
}

void LocalizerProcess::publish_graph(const std::vector<graph_node_t>& nodes, bool complete) {
  const std::size_t n_parts = (nodes.size() + kNodesPerPart - 1) / kNodesPerPart;
  for (std::size_t part = 0; part < n_parts; ++part) {
    graph_t message{};
    message.utime = newest_us_;
    message.revision = revision_;
    message.complete = complete ? 1 : 0;
    message.part = static_cast<std::int32_t>(part);
    message.n_parts = static_cast<std::int32_t>(n_parts);
    const auto begin = nodes.begin() + static_cast<std::ptrdiff_t>(part * kNodesPerPart);
    const auto end = nodes.begin() + static_cast<std::ptrdiff_t>(
                                         std::min(nodes.size(), (part + 1) * kNodesPerPart));
    message.nodes.assign(begin, end);
    message.n_nodes = static_cast<std::int32_t>(message.nodes.size());
    bus_.publish("GRAPH", message);
  }
}

}  // namespace fusion_slam
