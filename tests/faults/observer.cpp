// Listens to a live run like any viewer, for tests/faults/run. Prints one JSON object a line:
// STATUS of each process, and what poses, graph and tiles come. Reads commands from its input, one
// a line: `finish` (COMMAND finish to all), `write FOLDER` (trajectory and maps as they are now),
// `quit`.
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "fusion_slam/command_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/tile_channel.hpp"
#include "libs/clock/clock.hpp"
#include "libs/session/session_collector.hpp"

namespace fusion_slam {
namespace {

using Json = nlohmann::ordered_json;

class Observer {
 public:
  Observer() : bus_(options()) {
    listen<robot_model_t>("ROBOT_MODEL", &SessionCollector::on_robot_model);
    listen<camera_model_t>("CAMERA_MODEL", &SessionCollector::on_camera_model);
    listen<bot_core::pose_t>("GROUND_TRUTH", &SessionCollector::on_ground_truth);
    bus_.subscribe<bot_core::images_t>(
        "CAMERA", Policy::kLatestOnly,
        [this](const bot_core::images_t& m) { with([&] { collector_.on_camera(m.utime); }); });
    bus_.subscribe<bot_core::planar_lidar_t>(
        "LIDAR", Policy::kKeepAll,
        [this](const bot_core::planar_lidar_t& m) { with([&] { collector_.on_lidar(m.utime); }); });
    listen_and_say<pose_estimate_t>("VISUAL_POSE", &SessionCollector::on_visual_pose);
    listen_and_say<pose_estimate_t>("LIDAR_POSE", &SessionCollector::on_lidar_pose);
    listen_and_say<pose_estimate_t>("POSE", &SessionCollector::on_pose);
    listen_and_say<graph_t>("GRAPH", &SessionCollector::on_graph);
    bus_.subscribe<keyframe_t>("KEYFRAME", Policy::kKeepAll, [this](const keyframe_t& m) {
      with([&] { on_said({graph_node_t::KEYFRAME, m.id}, m.utime); });
    });
    bus_.subscribe<lidar_node_t>("LIDAR_NODE", Policy::kKeepAll, [this](const lidar_node_t& m) {
      with([&] { on_said({graph_node_t::LIDAR, m.id}, m.utime); });
    });
    for (const char* channel : {"GRID_FUSED", "GRID_LIDAR", "GRID_VISUAL", "OCTOMAP", "CLOUD"})
      tiles_.push_back(std::make_unique<TileReceiver>(bus_, channel, [=](const Tile& tile) {
        with([&] { collector_.on_tile(channel, tile); });
        say({{"channel", channel}});
      }));
    bus_.listen<status_t>("STATUS", [this](const status_t& m) { on_status(m); });
  }

  void run() {
    std::thread handling([this] { bus_.run(); });
    std::string line;
    while (std::getline(std::cin, line) && line != "quit") obey(line);
    bus_.stop();
    handling.join();
  }

 private:
  static BusOptions options() {
    BusOptions options;
    options.process = "fault_observer";
    return options;
  }
  template <class Act>
  void with(Act act) {
    const std::lock_guard<std::mutex> lock(mutex_);
    act();
  }
  void say(Json line) {
    line["at_s"] = static_cast<double>(steady_us()) * 1e-6;  // CLOCK_MONOTONIC, as Python's
    const std::lock_guard<std::mutex> lock(out_mutex_);
    std::cout << line.dump() << std::endl;
  }
  template <class Message, class Method>
  void listen(const std::string& channel, Method method) {
    bus_.subscribe<Message>(channel, Policy::kKeepAll, [this, method](const Message& m) {
      with([&] { (collector_.*method)(m); });
    });
  }
  template <class Message, class Method>
  void listen_and_say(const std::string& channel, Method method) {
    bus_.subscribe<Message>(channel, Policy::kKeepAll, [this, channel, method](const Message& m) {
      with([&] { (collector_.*method)(m); });
      if constexpr (std::is_same_v<Message, graph_t>)
        with([&] {
          for (const graph_node_t& node : m.nodes) in_graph_.insert({node.kind, node.id});
        });
      Json line{{"channel", channel}};
      if constexpr (std::is_same_v<Message, graph_t>)
        line["revision"] = m.revision;
      else
        line["ok"] = m.state == pose_estimate_t::OK || m.state == pose_estimate_t::WEAK;
      say(line);
    });
  }

  using Node = std::pair<std::int8_t, std::int64_t>;  // kind and id
  void on_said(const Node& node, std::int64_t utime_us) {
    if (const auto [it, is_new] = said_.emplace(node, utime_us); it->second != utime_us) ++twice_;
  }

  void on_status(const status_t& m) {
    std::int64_t lost = 0;
    std::int64_t received = 0;
    Json lost_on = Json::object();
    for (const channel_stats_t& channel : m.channels) {
      lost += channel.lost;
      if (channel.lost > 0) lost_on[channel.channel] = channel.lost;
      received += channel.received;
    }
    say({{"process", m.process},
         {"pid", m.pid},
         {"running", m.state == status_t::RUNNING},
         {"text", m.state_text},
         {"error", m.last_error},
         {"lost", lost},
         {"lost_on", lost_on},
         {"received", received},
         {"queue", m.queue},
         {"latency_ms_p95", m.latency_ms_p95},
         {"peak_rss_mb", static_cast<double>(m.peak_rss_bytes) / 1048576.0}});
  }

  void obey(const std::string& line) {
    std::istringstream words(line);
    std::string verb;
    std::string argument;
    words >> verb >> argument;
    if (verb == "finish") {
      command_t command{};
      command.utime = wall_us();
      command.verb = "finish";
      bus_.publish("COMMAND", command);
    } else if (verb == "write") {
      const std::lock_guard<std::mutex> lock(mutex_);
      const SessionResult result = collector_.write(argument);
      Json missing = Json::array();  // nodes that were said and are not in the graph
      for (const auto& [node, utime_us] : said_)
        if (in_graph_.count(node) == 0)
          missing.push_back((node.first == graph_node_t::LIDAR ? "LiDAR node " : "keyframe ") +
                            std::to_string(node.second));
      say({{"written", argument},
           {"damaged", result.damaged_tiles + result.damaged_messages},
           {"nodes", result.graph_nodes},
           {"said", said_.size()},
           {"missing", missing},
           {"twice", twice_}});
    }
  }

  Bus bus_;
  std::mutex mutex_;  // of collector_
  std::mutex out_mutex_;
  SessionCollector collector_;
  std::map<Node, std::int64_t> said_;  // by the trackers; utime
  std::set<Node> in_graph_;
  int twice_ = 0;  // an id that was given to two places
  std::vector<std::unique_ptr<TileReceiver>> tiles_;
};

}  // namespace
}  // namespace fusion_slam

int main() {
  try {
    fusion_slam::Observer().run();
  } catch (const std::exception& error) {
    std::cerr << "fault_observer: " << error.what() << std::endl;
    return 1;
  }
  return 0;
}
