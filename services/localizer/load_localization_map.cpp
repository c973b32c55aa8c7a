#include "services/localizer/load_localization_map.hpp"

#include <stdexcept>
#include <utility>

#include "fusion_slam/keyframe_t.hpp"
#include "libs/map_directory/decode.hpp"
#include "libs/messages/convert.hpp"
#include "libs/place_messages/place_messages.hpp"

namespace fusion_slam {
namespace {

TiledGrid lidar_grid(const MapState& state) {
  TiledGrid grid(state.robot.map_resolution_m);
  const auto tiles = state.tiles.find("GRID_LIDAR");
  if (tiles == state.tiles.end()) return grid;
  for (const auto& [key, message] : tiles->second) {
    const Tile tile = from_message(message);
    if (tile.resolution_m != grid.resolution_m()) continue;
    if (const auto cells = decode_grid_tile(tile)) grid.tiles()[{key.x, key.y}] = *cells;
  }
  return grid;
}

}  // namespace

LocalizationMap load_localization_map(const MapReader& reader, const MapState& state,
                                      const LocalizerConfig& config) {
  LocalizationMap map(state.robot, state.camera, config);
  map.set_grid(lidar_grid(state));
  const std::map<NodeId, SE3> T_map_nodes = state.graph.T_map_nodes();
  std::map<std::int64_t, MapView> views;
  reader.for_each([&](const LogEvent& event) {
    if (event.channel != "KEYFRAME") return;
    const auto message = decode<keyframe_t>(event);
    if (!message) return;
    const auto T_map_base = T_map_nodes.find({NodeKind::kKeyframe, message->id});
    std::string why;
    auto features = features_from(*message, &why);
    if (T_map_base == T_map_nodes.end() || !features) return;
    views[message->id] = {T_map_base->second, std::move(*features)};
  });
  for (auto& [id, view] : views) map.add_view(id, std::move(view));
  if (map.grid() == nullptr && map.views().empty())
    throw std::runtime_error(reader.directory().string() +
                             ": the map holds neither a LiDAR grid nor keyframes: nothing to "
                             "localise by");
  return map;
}

}  // namespace fusion_slam
