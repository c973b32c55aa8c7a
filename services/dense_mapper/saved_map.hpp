// What the dense mapper writes down of itself so that, started again, it need not look at an image
// twice: submaps as they are packed, where they lie, and what they say together. A journal holds
// records; each tells what has changed since the one before, or begins anew. Byte layout:
// docs/formats.md. Not thread-safe, deterministic.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "services/dense_mapper/dense_submap.hpp"
#include "services/dense_mapper/id_ranges.hpp"
#include "services/dense_mapper/level_wish.hpp"
#include "services/dense_mapper/mounting.hpp"

namespace fusion_slam {

using SavedBytes = std::vector<std::uint8_t>;

// A keyframe in a submap: its image is needed again as long as the submap is open.
struct SavedKeyframe {
  std::int64_t submap_id = 0;
  SE3 T_submap_camera = SE3::Identity();
};

// The few values that aren't submaps or base.
struct SavedValues {
  double resolution_m = 0.0;
  std::int64_t first_id = 1;
  std::int64_t base_upto = 0;
  std::int64_t newest_us = 0;
  std::int64_t placed_us = 0;
  std::int64_t level_keyframes = 0;
  bool levelled = false;
  bool floor_seen = false;
  std::optional<LevelWish> wish;
  Mounting mounting;
};

struct SavedMap {
  SavedValues values;
  DenseSubmaps submaps;  // those that are not closed are empty
  std::map<std::int64_t, SavedKeyframe> open_keyframes;
  IdRanges integrated;  // keyframes of closed submaps
  PackedCubes base_cubes;
  PackedCloud base_clouds;
  std::set<CubeIndex> dirty_base;  // cubes that do not follow a submap's move yet
};

// One record, put together piece by piece.
class SavedMapWriter {
 public:
  void values(const SavedValues& values);
  void keyframe(std::int64_t id, const SavedKeyframe& keyframe);
  void integrated(std::int64_t first, std::int64_t last);
  void whole_submap(std::int64_t id, const DenseSubmap& submap);   // closed
  void placed_submap(std::int64_t id, const DenseSubmap& submap);  // all but the content
  void gone_submap(std::int64_t id);
  void base_cube(const CubeIndex& index, const PackedBytes& bytes);  // no bytes: nothing there
  void base_cloud(const TileKey& key, const PackedBytes& bytes);
  void dirty_base(const std::set<CubeIndex>& cubes);  // all there are

  std::size_t size_bytes() const { return bytes_.size(); }
  SavedBytes take();  // begins another record

 private:
  SavedBytes bytes_;
};

// Applies a record to what the records before it have made. False: it is damaged or of another
// version; the map is then unspecified. Never throws on any bytes.
bool read_saved(const std::uint8_t* bytes, std::size_t size_bytes, SavedMap* map);

}  // namespace fusion_slam
