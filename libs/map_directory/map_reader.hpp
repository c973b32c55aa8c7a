// Opens a map directory for reading; never writes to it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "fusion_slam/tile_t.hpp"
#include "libs/eventlog/event.hpp"
#include "libs/map_directory/manifest.hpp"
#include "libs/map_directory/session_graph.hpp"
#include "libs/messages/models.hpp"
#include "libs/session/map_collection.hpp"

namespace fusion_slam {

class MapReader {
 public:
  // Checks the manifest, and each file's size and checksum against it. Throws std::runtime_error,
  // for people: no map, one of a newer format, a file that is missing, cut off or changed.
  explicit MapReader(const std::filesystem::path& directory);

  const std::filesystem::path& directory() const { return directory_; }
  const Manifest& manifest() const { return manifest_; }
  const MapSummary& summary() const { return manifest_.summary; }

  // Each message of the journal, in order. Throws std::runtime_error when one can't be decoded.
  void for_each(const std::function<void(const LogEvent&)>& visit) const;

 private:
  std::filesystem::path directory_;
  Manifest manifest_;
};

// The state of a map: what there is to show, and where it was seen from.
struct MapState {
  RobotModel robot;
  std::optional<CameraModel> camera;
  robot_model_t robot_message;
  std::optional<camera_model_t> camera_message;
  SessionGraph graph;
  std::map<std::string, std::map<TileKey, tile_t>> tiles;  // by channel; SUBMAP among them
  MapCollection maps;
};

// Throws std::runtime_error as for_each, or when the journal lacks ROBOT_MODEL.
MapState read_state(const MapReader& reader);

}  // namespace fusion_slam
