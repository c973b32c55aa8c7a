// Maps held as a listener holds them, and how good they are.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "drivers/simulator/truth_map.hpp"
#include "libs/grid/fused_tile.hpp"
#include "libs/tiles/tile.hpp"

namespace fusion_slam {

// A grid channel's tiles, the newest of each key. GRID_LIDAR and GRID_VISUAL count as fused ones
// without a sensor's name.
class HeldGrid {
 public:
  void take(const std::vector<Tile>& tiles);
  MapRaster raster(double resolution_m) const;

 private:
  std::map<TileIndex, FusedCells> tiles_;
};

// The truth of a world file, or (a folder) map.yaml and classes.pgm as simulate writes them.
TruthMap load_truth(const std::filesystem::path& path, const RobotModel& robot,
                    const Eigen::Vector2d& start_m);

// Cells, precision, recall, F1, recall by class; walls out of the camera's reach: wall cells of the
// truth without a known cell of `visual` within one cell. One line.
std::string score_line(const std::string& name, const TruthMap& truth, const MapRaster& map,
                       const MapRaster& visual, const SE2& T_world_map);

// Recall over those occupied cells of the truth only that are within one cell of `measured`: world
// cells (floor of x, y over the truth's resolution) in which some sensor measured a surface of the
// band during the drive. F1 with the precision of all cells. One line.
std::string measured_line(const std::string& name, const TruthMap& truth, const MapRaster& map,
                          const std::set<std::pair<int, int>>& measured);

// Pictures of truth and map on the same cells, four pixels a cell: black occupied, white free, grey
// unknown; of the map red: occupied where nothing is, blue: truth not found.
void write_pictures(const std::filesystem::path& prefix, const TruthMap& truth,
                    const MapRaster& map, const SE2& T_world_map);

}  // namespace fusion_slam
