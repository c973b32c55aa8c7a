#include "tests/bench/visual_odometry/recording_source.hpp"

#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <stdexcept>

#include "bot_core/images_t.hpp"
#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/graph_node_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/datasets/rgbd_dataset.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

template <class Message>
std::optional<Message> decoded(const LogEvent& event) {
  Message message;
  const int size = static_cast<int>(event.data.size());
  if (message.decode(event.data.data(), 0, size) < 0) return std::nullopt;
  return message;
}

Trajectory play_directory(const std::string& path, const BenchListener& listener) {
  const bool tum = std::filesystem::exists(std::filesystem::path(path) / "rgb.txt");
  const RgbdDataset dataset = tum ? open_tum_rgbd(path) : open_seven_scenes(path);
  RobotModel robot;
  robot.has_camera = true;
  robot.planar = false;
  listener.models(dataset.camera, robot);
  for (std::size_t i = 0; i < dataset.entries.size(); ++i) {
    std::string why;
    const auto frame = load_frame(dataset, i, &why);
    if (frame)
      listener.frame(*frame);
    else
      std::cerr << "frame " << i << ": " << why << '\n';
  }
  Trajectory reference;
  for (const ReferencePose& pose : dataset.reference)
    reference.push_back({pose.utime_us * 1e-6, pose.T_world_reference});
  return reference;
}

std::map<std::int64_t, SE3> read_lidar_poses(const std::string& path) {
  std::map<std::int64_t, SE3> poses;
  if (path.empty()) return poses;
  LogReader reader(path);
  LogEvent event;
  while (reader.next(&event)) {
    if (event.channel != "LIDAR_POSE") continue;
    const auto message = decoded<pose_estimate_t>(event);
    if (!message || message->state == pose_estimate_t::LOST) continue;
    if (const auto T = from_message(message->T_frame_base)) poses[message->utime] = *T;
  }
  return poses;
}

std::multimap<std::int64_t, graph_t> read_graph(const std::string& path) {
  std::multimap<std::int64_t, graph_t> revisions;
  if (path.empty()) return revisions;
  LogReader reader(path);
  LogEvent event;
  while (reader.next(&event))
    if (event.channel == "GRAPH")
      if (auto message = decoded<graph_t>(event))
        revisions.emplace(message->utime, std::move(*message));
  return revisions;
}

void tell(const graph_t& graph, const BenchListener& listener) {
  for (const graph_node_t& node : graph.nodes)
    if (node.kind == graph_node_t::KEYFRAME)
      if (const auto T = from_message(node.T_map_base)) listener.graph_node(node.id, *T);
}

Trajectory play_log(const std::string& path, const std::string& lidar_poses,
                    const std::string& graph, const BenchListener& listener) {
  const std::map<std::int64_t, SE3> lidar = read_lidar_poses(lidar_poses);
  auto next_lidar = lidar.begin();
  const std::multimap<std::int64_t, graph_t> revisions = read_graph(graph);
  auto next_revision = revisions.begin();
  LogReader reader(path);
  LogEvent event;
  std::string why;
  Trajectory reference;
  std::optional<CameraModel> camera;
  std::optional<RobotModel> robot;
  bool announced = false;
  while (reader.next(&event)) {
    if (event.channel == "CAMERA_MODEL" && !camera) {
      if (const auto m = decoded<camera_model_t>(event)) camera = from_message(*m, &why);
    } else if (event.channel == "ROBOT_MODEL" && !robot) {
      if (const auto m = decoded<robot_model_t>(event)) robot = from_message(*m, &why);
    } else if (event.channel == "GROUND_TRUTH") {
      const auto m = decoded<bot_core::pose_t>(event);
      if (const auto T = m ? from_message(*m) : std::nullopt)
        reference.push_back({m->utime * 1e-6, *T});
    }
    if (!camera || !robot) continue;
    if (!announced) listener.models(*camera, *robot);
    announced = true;
    if (event.channel == "ODOMETRY") {
      const auto m = decoded<bot_core::pose_t>(event);
      if (const auto T = m ? from_message(*m) : std::nullopt) listener.odometry(m->utime, *T);
    } else if (event.channel == "LIDAR") {
      const auto m = decoded<bot_core::planar_lidar_t>(event);
      if (const auto scan = m ? from_message(*m, &why) : std::nullopt) listener.scan(*scan);
    } else if (event.channel == "CAMERA") {
      const auto m = decoded<bot_core::images_t>(event);
      const auto frame = m ? from_message(*m, &why) : std::nullopt;
      if (!frame) continue;
      for (; next_lidar != lidar.end() && next_lidar->first < frame->utime_us; ++next_lidar)
        listener.lidar_pose(next_lidar->first, next_lidar->second);
      for (; next_revision != revisions.end() && next_revision->first < frame->utime_us;
           ++next_revision)
        tell(next_revision->second, listener);
      listener.frame(*frame);
    }
  }
  if (!announced) throw std::runtime_error(path + ": no CAMERA_MODEL and ROBOT_MODEL in this log");
  return reference;
}

}  // namespace

Trajectory play_recording(const std::string& path, const std::string& lidar_poses,
                          const std::string& graph, const BenchListener& listener) {
  return std::filesystem::is_directory(path) ? play_directory(path, listener)
                                             : play_log(path, lidar_poses, graph, listener);
}

}  // namespace fusion_slam
