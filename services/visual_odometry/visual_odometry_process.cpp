#include "services/visual_odometry/visual_odometry_process.hpp"

#include <string>
#include <utility>

#include "fusion_slam/graph_node_t.hpp"
#include "fusion_slam/keyframe_image_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "libs/place_messages/place_messages.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kResumeKeyframes = 60;  // of an earlier process: where the robot can be now

std::int8_t state_on_the_wire(TrackingState state) {
  if (state == TrackingState::kOk) return pose_estimate_t::OK;
  if (state == TrackingState::kWeak) return pose_estimate_t::WEAK;
  if (state == TrackingState::kLost) return pose_estimate_t::LOST;
  return pose_estimate_t::UNKNOWN;
}

std::string state_text(const TrackingResult& result) {
  const std::string count = std::to_string(result.n_matched) + " features matched, keyframe " +
                            std::to_string(result.reference_id);
  if (result.state == TrackingState::kOk) return "tracking: " + count;
  const std::string state = result.state == TrackingState::kWeak ? "weak: " : "lost: ";
  return state + result.reason + " (" + count + ")";
}

}  // namespace

VisualOdometryProcess::VisualOdometryProcess(Bus& bus, VisualOdometryConfig config)
    : bus_(bus), ids_(bus), config_(std::move(config)) {
  config_.wait_for_mapping = bus.mode() != Mode::kLive;  // a replay has no clock to keep
  cv::setNumThreads(
      1);  // one frame has little to share out, and the other processes need the cores
  bus_.subscribe<camera_model_t>("CAMERA_MODEL", Policy::kLatestOnly,
                                 [this](const camera_model_t& m) { on_camera_model(m); });
  bus_.subscribe<robot_model_t>("ROBOT_MODEL", Policy::kLatestOnly,
                                [this](const robot_model_t& m) { on_robot_model(m); });
  bus_.subscribe<bot_core::planar_lidar_t>(
      "LIDAR", Policy::kLatestOnly, [this](const bot_core::planar_lidar_t& m) { on_lidar(m); });
  bus_.subscribe<pose_estimate_t>("LIDAR_POSE", Policy::kKeepAll,
                                  [this](const pose_estimate_t& m) { on_lidar_pose(m); });
  bus_.subscribe<graph_t>("GRAPH", Policy::kKeepAll, [this](const graph_t& m) { on_graph(m); });
  bus_.subscribe<bot_core::images_t>("CAMERA", Policy::kLatestOnly,
                                     [this](const bot_core::images_t& m) { on_camera(m); });
  if (bus.mode() != Mode::kLive)  // on the reader's thread, when it arrives; its turn comes later
    bus_.listen<bot_core::images_t>("CAMERA", [ahead = ahead_](const bot_core::images_t& m) {
      const std::lock_guard<std::mutex> lock(ahead->mutex);
      if (!ahead->frames) return;
      ahead->frames->begin(m.utime, [m] {
        std::string why;
        return from_message(m, &why);
      });
    });
  bus_.subscribe<command_t>("COMMAND", Policy::kKeepAll,
                            [this](const command_t& m) { on_command(m); });
  bus_.never_await({"GRAPH", "LIDAR_POSE"});  // they are made of our poses
  bus_.keep_in_journal({"CAMERA_MODEL", "ROBOT_MODEL"});
  // Both are written before they are sent: who asks for them after a crash gets them.
  bus_.keep_said<keyframe_t>("KEYFRAME", [this](const keyframe_t& m) { on_earlier_keyframe(m); });
  bus_.keep_said<keyframe_image_t>("KEYFRAME_IMAGE", [](const keyframe_image_t&) {});
  // RESEND is answered by the latest only, and the latest keyframes are its map again.
  bus_.keep_journal_small({{"CAMERA_MODEL", "ROBOT_MODEL"}, {}, {}});
  bus_.set_state_text("waiting for CAMERA_MODEL, ROBOT_MODEL and CAMERA");
}

void VisualOdometryProcess::on_earlier_keyframe(const keyframe_t& message) {
  std::string why;
  std::optional<FeatureSet> features = features_from(message, &why);
  const std::optional<SE3> T_odom_base = from_message(message.T_odom_base);
  if (!features || !T_odom_base) return;
  ids_.said(message.id);
  if (message.previous_id == 0) earlier_.clear();  // a segment of its own
  Keyframe keyframe;
  keyframe.id = message.id;
  keyframe.utime_us = message.utime;
  keyframe.T_odom_base = *T_odom_base;
  keyframe.previous_id = message.previous_id;
  keyframe.features = std::move(*features);
  keyframe.landmark_of_feature = message.landmark_id;
  earlier_.push_back(std::move(keyframe));
  if (earlier_.size() > kResumeKeyframes) earlier_.pop_front();
}

void VisualOdometryProcess::on_camera_model(const camera_model_t& message) {
  if (camera_) return;
  std::string why;
  camera_ = from_message(message, &why);
  if (!camera_) bus_.report_error("CAMERA_MODEL refused: " + why);
}

void VisualOdometryProcess::on_robot_model(const robot_model_t& message) {
  if (robot_) return;
  std::string why;
  robot_ = from_message(message, &why);
  if (!robot_) bus_.report_error("ROBOT_MODEL refused: " + why);
}

void VisualOdometryProcess::on_lidar(const bot_core::planar_lidar_t& message) {
  std::string why;
  std::optional<LaserScan> scan = from_message(message, &why);
  if (!scan) return bus_.report_error("LIDAR refused: " + why);
  if (odometry_) odometry_->add_scan(std::move(*scan));
}

void VisualOdometryProcess::on_lidar_pose(const pose_estimate_t& message) {
  const bool measured =
      message.state == pose_estimate_t::OK || message.state == pose_estimate_t::WEAK;
  if (!odometry_ || !measured) return;
  if (const std::optional<SE3> T_odom_base = from_message(message.T_frame_base))
    odometry_->add_lidar_pose(message.utime, *T_odom_base);
  else
    bus_.report_error("LIDAR_POSE refused: the pose is not a rigid motion");
}

void VisualOdometryProcess::on_graph(const graph_t& message) {
  if (!odometry_) return;
  for (const graph_node_t& node : message.nodes)
    if (node.kind == graph_node_t::KEYFRAME)
      if (const std::optional<SE3> T_map_base = from_message(node.T_map_base))
        odometry_->add_graph_node(node.id, *T_map_base);
}

void VisualOdometryProcess::on_command(const command_t& message) {
  if (reset_.asks(message) && odometry_) odometry_->reset();
}

void VisualOdometryProcess::on_camera(const bot_core::images_t& message) {
  if (!odometry_) {
    if (!camera_ || !robot_)
      return bus_.report_error("CAMERA ignored: no CAMERA_MODEL or ROBOT_MODEL yet");
    odometry_ = std::make_unique<VisualOdometry>(*camera_, *robot_, config_);
    odometry_->resume({earlier_.begin(), earlier_.end()}, ids_.next());
    earlier_.clear();
    const std::lock_guard<std::mutex> lock(ahead_->mutex);
    if (bus_.mode() != Mode::kLive)
      ahead_->frames = std::make_shared<FramesAhead>(*camera_, config_.orb);
  }
  std::string why;
  std::optional<SeenFrame> ahead =
      ahead_->frames ? ahead_->frames->take(message.utime) : std::nullopt;
  const std::optional<RgbdFrame> frame =
      ahead ? std::move(ahead->frame) : from_message(message, &why);
  if (!frame) return bus_.report_error("CAMERA refused: " + why);
  const TrackingResult result = odometry_->track(*frame, ahead ? &ahead->features : nullptr);
  if (result.state == TrackingState::kUnknown)
    return bus_.report_error("CAMERA refused: " + result.reason);
  if (result.keyframe) publish_keyframe(*result.keyframe, message);
  publish_pose(result);
  bus_.set_state_text(state_text(result));
}

void VisualOdometryProcess::publish_pose(const TrackingResult& result) {
  pose_estimate_t message{};
  message.utime = result.utime_us;
  message.frame = "odom";
  message.T_frame_base = to_message(result.T_odom_base, result.utime_us);
  to_message(result.covariance, message.covariance);
  message.state = state_on_the_wire(result.state);
  message.reason = result.reason;
  message.reference_kind = result.reference_id > 0 ? graph_node_t::KEYFRAME : std::int8_t{-1};
  message.reference_id = result.reference_id;
  message.T_reference_base = to_message(result.T_reference_base, result.utime_us);
  message.fix_utime = result.fix_utime_us;
  message.n_matched = result.n_matched;
  bus_.publish("VISUAL_POSE", std::move(message));
}

void VisualOdometryProcess::publish_keyframe(const Keyframe& keyframe,
                                             const bot_core::images_t& images) {
  keyframe_t message{};
  message.utime = keyframe.utime_us;
  message.id = keyframe.id;
  message.T_odom_base = to_message(keyframe.T_odom_base, keyframe.utime_us);
  message.previous_id = keyframe.previous_id;
  message.T_previous_base = to_message(keyframe.T_previous_base, keyframe.utime_us);
  to_message(keyframe.covariance, message.covariance);
  const FeatureSet& set = keyframe.features;
  message.n = static_cast<std::int32_t>(set.size());
  message.n_descriptor_bytes = static_cast<std::int32_t>(set.size() * kDescriptorBytes);
  message.descriptors.resize(set.size() * kDescriptorBytes);
  for (std::size_t i = 0; i < set.size(); ++i) {
    const Feature& f = set.features[i];
    message.u_px.push_back(f.u_px);
    message.v_px.push_back(f.v_px);
    message.depth_m.push_back(f.depth_m);
    message.angle_rad.push_back(f.angle_rad);
    message.octave.push_back(f.octave);
    message.depth_sigma_m.push_back(f.depth_sigma_m);
    message.landmark_id.push_back(keyframe.landmark_of_feature[i]);
    descriptor_to_bytes(set.descriptors[i], message.descriptors.data() + i * kDescriptorBytes);
  }
  message.n_refined = static_cast<std::int32_t>(keyframe.refined.size());
  for (const RefinedEdge& edge : keyframe.refined) {
    message.refined_id.push_back(edge.id);
    message.T_previous_refined.push_back(to_message(edge.T_previous_base, keyframe.utime_us));
  }
  bus_.publish("KEYFRAME", std::move(message));
  keyframe_image_t image{};
  image.utime = keyframe.utime_us;
  image.id = keyframe.id;
  image.images = images;
  bus_.publish("KEYFRAME_IMAGE", std::move(image));
}

}  // namespace fusion_slam
