#include "libs/map_directory/map_saver.hpp"

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "libs/eventlog/reader.hpp"
#include "libs/map_directory/configuration.hpp"
#include "libs/map_directory/decode.hpp"
#include "libs/maps/atomic_file.hpp"
#include "libs/messages/convert.hpp"
#include "libs/schema/guard.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

const std::set<std::string> kStreams{"KEYFRAME", "KEYFRAME_IMAGE", "LIDAR_NODE", "CONSTRAINT",
                                     "LEVEL",    "VISUAL_POSE",    "LIDAR_POSE", "ODOMETRY"};
const std::set<std::string> kModels{"ROBOT_MODEL", "CAMERA_MODEL"};
const std::set<std::string> kTiles{"SUBMAP",     "GRID_LIDAR", "GRID_VISUAL",
                                   "GRID_FUSED", "OCTOMAP",    "CLOUD"};

template <class Message>
std::vector<std::uint8_t> encoded(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

TileKey key_of(const tile_t& tile) { return {tile.submap_id, tile.x, tile.y, tile.z}; }

fs::path session_log(const fs::path& session) {
  fs::path log = fs::is_directory(session) ? session / "session.lcmlog" : session;
  if (!fs::exists(log))
    throw std::runtime_error(log.string() +
                             ": there is no such file; give the session.lcmlog that "
                             "`fusion-slam run` or `fusion-slam record` leaves, or its folder");
  return log;
}

}  // namespace

bool is_journal_channel(const std::string& channel) {
  return channel == "GRAPH" || kStreams.count(channel) + kModels.count(channel) > 0 ||
         kTiles.count(channel) > 0;
}

void check_is_map_or_nothing(const fs::path& target) {
  if (!fs::exists(fs::symlink_status(target))) return;
  if (fs::is_directory(target) && (fs::is_empty(target) || fs::exists(target / kManifestName)))
    return;
  throw std::runtime_error(target.string() +
                           ": is something other than a map and would be replaced: give a new "
                           "name, or the directory of a map");
}

MapSaver::MapSaver(const fs::path& target, const MapSaveOptions& options)
    : target_((check_is_map_or_nothing(target), target)),
      options_(options),
      directory_(target),
      journal_(directory_.path() / kJournalName) {
  summary_.sessions = options.sessions;
}

void MapSaver::write(std::int64_t timestamp_us, const std::string& channel,
                     const std::vector<std::uint8_t>& bytes) {
  journal_.write(timestamp_us, channel, bytes);
}

// Lost messages are sent again with the number they had.
bool MapSaver::is_repeat(const LogEvent& event) {
  const auto seq = peek_seq(event.data.data(), event.data.size());
  return seq && !seqs_[event.channel].insert(*seq).second;
}

void MapSaver::add(const LogEvent& event) {
  if (event.channel == "LOCALIZATION") localised_ = true;
  if (!is_journal_channel(event.channel)) {
    if (event.channel == "CAMERA" || event.channel == "LIDAR")
      if (const auto utime_us = peek_utime(event.data.data(), event.data.size()))
        event.channel == "CAMERA" ? collector_.on_camera(*utime_us)
                                  : collector_.on_lidar(*utime_us);
    return;
  }
  const LcmType* type = peek_type(event.data.data(), event.data.size());
  if (type == nullptr || check(*type, event.data.data(), event.data.size())) {
    ++undecodable_;
    return;
  }
  newest_us_ = std::max(newest_us_, event.timestamp_us);
  if (kTiles.count(event.channel) > 0) return add_tile(event);
  if (event.channel == "GRAPH") {
    if (const auto graph = decode<graph_t>(event)) graph_.add(*graph), collector_.on_graph(*graph);
    return;
  }
  if (kModels.count(event.channel) > 0) {
    if (!models_.insert(event.channel).second) return;
    if (const auto m = decode<robot_model_t>(event)) collector_.on_robot_model(*m);
    if (const auto m = decode<camera_model_t>(event)) collector_.on_camera_model(*m);
  } else {
    if (is_repeat(event)) return;
    if (event.channel == "KEYFRAME_IMAGE") {
      if (!options_.images) return;
      ++summary_.images;
    }
    if (event.channel == "KEYFRAME") ++summary_.keyframes;
    if (event.channel == "LIDAR_NODE") ++summary_.lidar_nodes;
    if (event.channel == "CONSTRAINT") ++summary_.loops;
    if (event.channel == "VISUAL_POSE")
      if (const auto m = decode<pose_estimate_t>(event)) collector_.on_visual_pose(*m);
    if (event.channel == "LIDAR_POSE")
      if (const auto m = decode<pose_estimate_t>(event)) collector_.on_lidar_pose(*m);
  }
  write(event.timestamp_us, event.channel, event.data);
}

void MapSaver::add_tile(const LogEvent& event) {
  const auto tile = decode<tile_t>(event);
  if (!tile) return;
  collector_.on_tile(event.channel, *tile);
  const auto [held, made] = tiles_.try_emplace({event.channel, key_of(*tile)}, *tile);
  if (!made && tile->revision > held->second.revision) held->second = *tile;
}

// The newest state of what is state and not history.
void MapSaver::write_state() {
  for (const graph_t& part : graph_.messages()) write(newest_us_, "GRAPH", encoded(part));
  std::map<std::string, std::int64_t> seq;
  std::set<std::int64_t> submaps;
  for (auto& [key, tile] : tiles_) {
    if (tile.encoding == tile_t::EMPTY) continue;
    if (key.first == "SUBMAP") submaps.insert(tile.submap_id);
    tile.seq = ++seq[key.first];
    write(newest_us_, key.first, encoded(tile));
  }
  summary_.submaps = static_cast<std::int64_t>(submaps.size());
  journal_.close();
}

MapSummary MapSaver::finish() {
  if (localised_)
    throw std::runtime_error(
        "the session localised in a saved map and made none of its own: `run --mode continue` adds "
        "a session to a map");
  if (graph_.empty() && undecodable_ > 0)
    throw std::runtime_error("the session holds no GRAPH that can be read (" +
                             std::to_string(undecodable_) +
                             " messages are damaged or of another version of Fusion-SLAM): run its "
                             "log again");
  if (graph_.empty() || !collector_.robot())
    throw std::runtime_error(std::string("the session holds no ") +
                             (graph_.empty() ? "GRAPH" : "ROBOT_MODEL") +
                             ": no map was made in it. Give the session.lcmlog that `fusion-slam "
                             "run` leaves, or what `fusion-slam record` recorded beside the "
                             "services from their start");
  // seq grows by one a message, from 1.
  for (const std::string channel : {"KEYFRAME", "KEYFRAME_IMAGE", "LIDAR_NODE", "CONSTRAINT"}) {
    const auto& seen = seqs_[channel];
    if (seen.empty()) continue;
    const std::int64_t lost = *seen.rbegin() - static_cast<std::int64_t>(seen.size());
    if (lost > 0) summary_.lost[channel] = lost;
  }
  write_state();
  const RobotModel& robot = *collector_.robot();
  const SessionResult result = collector_.write(directory_.path());
  write_file_atomically(directory_.path() / "configuration.yaml",
                        configuration_yaml(robot, collector_.camera_model()));
  summary_.robot = robot.name;
  summary_.has_lidar = robot.has_lidar && summary_.lidar_nodes > 0;
  summary_.has_camera = robot.has_camera && summary_.keyframes > 0;
  summary_.resolution_m = robot.map_resolution_m;
  summary_.path_length_m = result.path_length_m;
  summary_.free_area_m2 = result.free_area_m2;
  summary_.grid = result.map_source;
  const auto& nodes = graph_.nodes();
  summary_.first_utime_us = nodes.begin()->second.second.utime;
  summary_.last_utime_us = summary_.first_utime_us;
  for (const auto& [id, node] : nodes) {
    summary_.first_utime_us = std::min(summary_.first_utime_us, node.second.utime);
    summary_.last_utime_us = std::max(summary_.last_utime_us, node.second.utime);
  }
  Manifest manifest;
  manifest.summary = summary_;
  for (const auto& entry : fs::directory_iterator(directory_.path()))
    manifest.files[entry.path().filename().string()] = measure_file(entry.path());
  write_file_atomically(directory_.path() / kManifestName, to_json(manifest));
  check_is_map_or_nothing(target_);  // nobody put something else there meanwhile
  directory_.commit();
  return summary_;
}

MapSummary save_session(const fs::path& session, const fs::path& target,
                        const MapSaveOptions& options) {
  LogReader reader(session_log(session));
  MapSaver saver(target, options);
  LogEvent event;
  while (reader.next(&event) || reader.resync()) {
    if (!event.data.empty()) saver.add(event);
    event.data.clear();
  }
  try {
    return saver.finish();
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(session.string() + " to " + target.string() + ": " + error.what());
  }
}

}  // namespace fusion_slam
