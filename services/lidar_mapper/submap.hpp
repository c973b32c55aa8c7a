// A small map built rigidly around one node, and the two of them that grow at any time (Hess et al.
// 2016, section IV.D).
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "libs/scan_matching/surface_map.hpp"
#include "libs/tiles/tile.hpp"
#include "services/lidar_mapper/occupancy_grid.hpp"
#include "services/lidar_mapper/scan_points.hpp"

namespace fusion_slam {

class Submap {
 public:
  // The grid's frame is the base of the anchor node; the submap is named after it.
  Submap(std::int64_t anchor_node_id, const SE2& T_odom_submap, double resolution_m,
         const LidarMapperConfig& config);

  std::int64_t id() const { return id_; }
  const SE2& T_odom_submap() const { return T_odom_submap_; }
  const Raster& raster() const { return grid_.raster(); }
  const SurfaceMap& surfaces() const { return surfaces_; }  // in the same frame
  int n_scans() const { return n_scans_; }

  void insert(const ScanPoints& scan, const SE2& T_odom_base, std::int64_t utime_us);

  // Tiles that changed since the last call, in order, with their next revision.
  std::vector<Tile> take_changed_tiles();

 private:
  std::int64_t id_;
  SE2 T_odom_submap_;
  OccupancyGrid grid_;
  SurfaceMap surfaces_;
  int n_scans_ = 0;
  std::int64_t newest_us_ = 0;
  std::map<TileIndex, std::int64_t> revisions_;
};

// The older one is what scans are matched against; both take every node's scan, so that a new one
// is well filled before it is the older.
class ActiveSubmaps {
 public:
  ActiveSubmaps(double resolution_m, const LidarMapperConfig& config)
      : resolution_m_(resolution_m), config_(config) {}

  bool empty() const { return submaps_.empty(); }
  const Submap& oldest() const { return submaps_.front(); }
  const std::vector<Submap>& all() const { return submaps_; }

  // Starts a submap at this node when it is time, inserts the scan, then finishes a full submap:
  // its last tiles are returned. all() afterwards no longer holds it, inserted_into() does.
  std::vector<Tile> insert(std::int64_t node_id, const ScanPoints& scan, const SE2& T_odom_base,
                           std::int64_t utime_us);
  struct Membership {
    std::int64_t submap_id;
    SE2 T_submap_base;
  };
  const std::vector<Membership>& inserted_into() const { return inserted_into_; }

  // An earlier process's submap, before any insert(): in order of their anchors.
  void restore(Submap submap) { submaps_.push_back(std::move(submap)); }
  // Finishes what restore() brought and is full already. Returns its last tiles.
  std::vector<Tile> finish_full();

  std::vector<Tile> take_changed_tiles();
  // Ends the active submaps: the next node starts afresh. Returns their last tiles.
  std::vector<Tile> finish_all();

 private:
  double resolution_m_;
  LidarMapperConfig config_;
  std::vector<Submap> submaps_;  // oldest first, at most two
  std::vector<Membership> inserted_into_;
};

}  // namespace fusion_slam
