#include "logplayer/run/listener.hpp"

#include <iostream>

#include "libs/bus/transport.hpp"
#include "libs/schema/guard.hpp"

namespace fusion_slam {
namespace {

BusOptions options() {
  BusOptions options;
  options.process = "run";
  options.mode = Mode::kThroughput;
  return options;
}

}  // namespace

Listener::Listener(std::shared_ptr<Transport> transport) : bus_(options(), std::move(transport)) {
  const auto listen = [this](auto method, const std::string& channel, auto message) {
    using Message = decltype(message);
    bus_.subscribe<Message>(channel, Policy::kKeepAll, [this, method](const Message& m) {
      const std::lock_guard<std::mutex> lock(mutex_);
      (collector_.*method)(m);
    });
  };
  listen(&SessionCollector::on_robot_model, "ROBOT_MODEL", robot_model_t{});
  listen(&SessionCollector::on_camera_model, "CAMERA_MODEL", camera_model_t{});
  listen(&SessionCollector::on_ground_truth, "GROUND_TRUTH", bot_core::pose_t{});
  listen(&SessionCollector::on_visual_pose, "VISUAL_POSE", pose_estimate_t{});
  listen(&SessionCollector::on_lidar_pose, "LIDAR_POSE", pose_estimate_t{});
  listen(&SessionCollector::on_pose, "POSE", pose_estimate_t{});
  listen(&SessionCollector::on_graph, "GRAPH", graph_t{});
  bus_.subscribe<pose_estimate_t>("LOCALIZATION", Policy::kKeepAll,
                                  [this](const pose_estimate_t& m) { on_localization(m); });
  for (const char* channel : {"GRID_FUSED", "GRID_LIDAR", "GRID_VISUAL", "OCTOMAP", "CLOUD"})
    tiles_.push_back(std::make_unique<TileReceiver>(bus_, channel, [this, channel](const Tile& t) {
      const std::lock_guard<std::mutex> lock(mutex_);
      collector_.on_tile(channel, t);
    }));
  thread_ = std::thread([this] {
    try {
      bus_.run();
    } catch (const std::exception& error) {
      bus_.report_error(std::string("the collector stopped: ") + error.what());
    }
  });
}

Listener::~Listener() {
  bus_.stop();
  thread_.join();
}

void Listener::sensor_event(const LogEvent& event) {
  const auto utime_us = peek_utime(event.data.data(), event.data.size());
  if (!utime_us) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (event.channel == "CAMERA") collector_.on_camera(*utime_us);
  if (event.channel == "LIDAR") collector_.on_lidar(*utime_us);
}

bool Listener::has_all(const std::map<std::string, std::int64_t>& counts) const {
  for (const auto& [channel, processed] : bus_.processed()) {
    const auto sent = counts.find(channel);
    if (sent != counts.end() && processed < sent->second) return false;
  }
  return true;
}

void Listener::on_localization(const pose_estimate_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  LocalizationSummary& summary = localization_;
  summary.state = message.reason;
  const bool localized = message.state == pose_estimate_t::OK;
  if (localized && summary.localized_utime_us == 0) summary.localized_utime_us = message.utime;
  summary.times_lost += localized_ && !localized ? 1 : 0;
  localized_ = localized;
}

LocalizationSummary Listener::localization() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return localization_;
}

SessionResult Listener::write(const std::filesystem::path& out) {
  const std::lock_guard<std::mutex> lock(mutex_);
  return collector_.write(out);
}

}  // namespace fusion_slam
