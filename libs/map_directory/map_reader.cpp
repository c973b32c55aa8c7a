#include "libs/map_directory/map_reader.hpp"

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "libs/eventlog/reader.hpp"
#include "libs/map_directory/decode.hpp"
#include "libs/messages/convert.hpp"
#include "libs/schema/guard.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

std::string read_manifest(const fs::path& directory) {
  if (!fs::is_directory(directory))
    throw std::runtime_error(
        directory.string() + ": " +
        (fs::exists(directory) ? "is a file; a map is a directory" : "there is no such directory") +
        ": `fusion-slam map save SESSION DIR` makes one");
  std::ifstream file(directory / kManifestName, std::ios::binary);
  if (!file)
    throw std::runtime_error(directory.string() + ": is no Fusion-SLAM map: it has no " +
                             kManifestName + ". `fusion-slam map save` makes a map of a session");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void check_file(const fs::path& path, const MapFile& expected) {
  if (!fs::is_regular_file(path))
    throw std::runtime_error(path.string() + ": is missing: the map was not copied whole");
  const auto size = static_cast<std::int64_t>(fs::file_size(path));
  if (size != expected.size_bytes)
    throw std::runtime_error(path.string() + ": has " + std::to_string(size) +
                             " bytes instead of " + std::to_string(expected.size_bytes) +
                             ": it was cut off or changed; copy the map again");
  if (measure_file(path).crc32 != expected.crc32)
    throw std::runtime_error(path.string() +
                             ": its checksum is wrong: it was changed or the disk is failing; copy "
                             "the map again");
}

}  // namespace

MapReader::MapReader(const fs::path& directory)
    : directory_(directory), manifest_(parse_manifest(read_manifest(directory), directory)) {
  for (const auto& [name, file] : manifest_.files) check_file(directory_ / name, file);
}

void MapReader::for_each(const std::function<void(const LogEvent&)>& visit) const {
  LogReader reader(directory_ / kJournalName);
  LogEvent event;
  while (reader.next(&event)) {
    const LcmType* type = peek_type(event.data.data(), event.data.size());
    const auto problem = type == nullptr ? std::optional<std::string>("its type is unknown")
                                         : check(*type, event.data.data(), event.data.size());
    if (problem)
      throw std::runtime_error(reader.path().string() + ": event " + std::to_string(event.number) +
                               " (" + event.channel + "): " + *problem +
                               ": the map is of another version, or damaged");
    visit(event);
  }
  if (reader.damage()) throw std::runtime_error(reader.damage()->message);
}

MapState read_state(const MapReader& reader) {
  MapState state;
  bool has_robot = false;
  std::string why = "the journal holds no ROBOT_MODEL";
  reader.for_each([&](const LogEvent& event) {
    if (event.channel == "ROBOT_MODEL") {
      const auto message = decode<robot_model_t>(event);
      if (!message) return;
      if (const auto robot = from_message(*message, &why)) {
        state.robot = *robot;
        state.robot_message = *message;
        has_robot = true;
      }
    } else if (event.channel == "CAMERA_MODEL") {
      const auto message = decode<camera_model_t>(event);
      std::string ignored;
      if (message) state.camera = from_message(*message, &ignored);
      if (state.camera) state.camera_message = *message;
    } else if (event.channel == "GRAPH") {
      if (const auto graph = decode<graph_t>(event)) state.graph.add(*graph);
    } else if (const auto tile = decode<tile_t>(event)) {
      state.tiles[event.channel][{tile->submap_id, tile->x, tile->y, tile->z}] = *tile;
      state.maps.add(event.channel, from_message(*tile));
    }
  });
  if (!has_robot) throw std::runtime_error(reader.directory().string() + ": " + why);
  return state;
}

}  // namespace fusion_slam
