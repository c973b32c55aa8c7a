// The LiDAR's submaps as loop closing needs them: which nodes they hold, and a raster with its
// search pyramid while one is searched. Tiles are kept as they came (deflated); few submaps are
// unpacked at a time, so memory grows with the area mapped and slowly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "libs/journal/note_bytes.hpp"
#include "libs/scan_matching/search_pyramid.hpp"
#include "libs/tiles/tile.hpp"
#include "services/loop_detector/loop_types.hpp"

namespace fusion_slam {

struct UnpackedSubmap {
  Raster raster;
  SearchPyramid pyramid;
};

class SubmapStore {
 public:
  explicit SubmapStore(std::size_t most_unpacked = 16) : most_unpacked_(most_unpacked) {}

  void add_tile(const Tile& tile);
  void add_scan(const LoopScan& scan);
  // Nobody will ask for its submaps again; it stays a member of them.
  void forget_scan(std::int64_t node_id) { submaps_of_.erase(node_id); }

  struct Member {
    std::int64_t node_id = 0;
    SE2 T_submap_base;
  };
  struct Submap {
    std::vector<Member> members;  // in the order of their ids
    std::int64_t last_utime_us = 0;
    std::map<TileKey, Tile> tiles;
    std::int64_t revision = 0;  // grows with its tiles
  };
  const std::map<std::int64_t, Submap>& all() const { return submaps_; }
  // Submaps that a scan was inserted into; empty: unknown.
  const std::vector<LoopScan::Membership>& submaps_of(std::int64_t node_id) const;

  // Which scans lie where, in a journal note, and back; tiles come again from who made them.
  void write(NoteWriter* out) const;
  void read(NoteReader* in);

  // Good until the next call; nullptr when no tile of it came.
  const UnpackedSubmap* unpacked(std::int64_t submap_id);

 private:
  struct Unpacked {
    std::int64_t revision = 0;
    std::int64_t used = 0;
    std::unique_ptr<UnpackedSubmap> content;
  };

  std::size_t most_unpacked_;
  std::int64_t uses_ = 0;
  std::map<std::int64_t, Submap> submaps_;
  std::map<std::int64_t, std::vector<LoopScan::Membership>> submaps_of_;
  std::map<std::int64_t, Unpacked> unpacked_;
};

}  // namespace fusion_slam
