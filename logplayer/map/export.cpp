#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>

#include "libs/evaluation/tum_file.hpp"
#include "libs/map_directory/map_reader.hpp"
#include "libs/maps/atomic_file.hpp"
#include "libs/maps/map_picture.hpp"
#include "libs/maps/octomap_file.hpp"
#include "libs/maps/pcd_file.hpp"
#include "libs/maps/ply_file.hpp"
#include "libs/maps/ros_map.hpp"
#include "logplayer/map/commands.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

std::string trajectory(const MapReader& reader) {
  const fs::path file = reader.directory() / "trajectory.tum";
  if (reader.manifest().files.count("trajectory.tum") == 0)
    throw std::runtime_error(reader.directory().string() + ": the map has no trajectory");
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

MapRaster raster(const MapState& state, const MapOptions& options) {
  std::string why, source;
  const auto grid = options.grid == "best"    ? state.maps.grid(&source, &why)
                    : options.grid == "fused" ? state.maps.grid_of("GRID_FUSED", &why)
                    : options.grid == "lidar" ? state.maps.grid_of("GRID_LIDAR", &why)
                                              : state.maps.grid_of("GRID_VISUAL", &why);
  if (!grid) throw std::runtime_error(options.map.string() + ": no such grid: " + why);
  return *grid;
}

std::string picture(const MapReader& reader, const MapRaster& raster) {
  std::vector<Eigen::Vector2d> way_m;
  if (reader.manifest().files.count("trajectory.tum") > 0)
    for (const StampedPose& pose : read_tum(reader.directory() / "trajectory.tum").trajectory)
      way_m.emplace_back(pose.T_world_body.translation().head<2>());
  return map_png_bytes(raster, way_m);
}

void write(const fs::path& file, const std::string& bytes) {
  write_file_atomically(file, bytes);
  std::cout << file.string() << ": " << bytes.size() << " bytes\n";
}

// OUT may be named by the picture or by its YAML: both are written, side by side.
void write_ros_map(const MapRaster& raster, fs::path out) {
  if (out.extension() != ".pgm") out.replace_extension(".pgm");
  write(out, pgm_bytes(raster));
  write(fs::path(out).replace_extension(".yaml"), map_yaml(raster, out.filename().string()));
}

}  // namespace

int export_map(const MapOptions& options) {
  const MapReader reader(options.map);
  if (options.format == "tum") return write(options.out, trajectory(reader)), 0;
  const MapState state = read_state(reader);
  std::string why;
  if (options.format == "pgm") {
    write_ros_map(raster(state, options), options.out);
  } else if (options.format == "png") {
    write(options.out, picture(reader, raster(state, options)));
  } else if (options.format == "bt" || options.format == "ot") {
    const auto bytes = options.format == "bt" ? octomap_bt_bytes(state.maps.octomap(), &why)
                                              : octomap_ot_bytes(state.maps.octomap(), &why);
    if (!bytes) throw std::runtime_error(options.map.string() + ": no OctoMap: " + why);
    write(options.out, *bytes);
  } else {
    const auto cloud = state.maps.cloud();
    if (cloud.empty()) throw std::runtime_error(options.map.string() + ": the map has no cloud");
    write(options.out, options.format == "ply" ? ply_bytes(cloud) : pcd_bytes(cloud));
  }
  return 0;
}

}  // namespace fusion_slam
