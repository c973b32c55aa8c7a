#include "services/dense_mapper/saved_map.hpp"

#include "libs/journal/note_bytes.hpp"

namespace fusion_slam {
namespace {

constexpr std::uint8_t kVersion = 1;
enum Piece : std::uint8_t {
  kValues = 1,
  kKeyframe = 2,
  kIntegrated = 3,
  kWholeSubmap = 4,
  kPlacedSubmap = 5,
  kGoneSubmap = 6,
  kBaseCube = 7,
  kBaseCloud = 8,
  kDirtyBase = 9,
};

void put_index(const CubeIndex& index, NoteWriter* out) {
  out->put(index.x);
  out->put(index.y);
  out->put(index.z);
}
// Farther away than a pose may be there is nothing, and numbers overflow.
int get_coordinate(NoteReader* in) {
  const int number = in->get<int>();
  in->expect(number > -10'000'000 && number < 10'000'000);
  return in->good() ? number : 0;
}
CubeIndex get_index(NoteReader* in) {
  const int x = get_coordinate(in);
  const int y = get_coordinate(in);
  return {x, y, get_coordinate(in)};
}

void put_key(const TileKey& key, NoteWriter* out) {
  out->put(key.submap_id);
  out->put(key.x);
  out->put(key.y);
  out->put(key.z);
}
TileKey get_key(NoteReader* in) {
  TileKey key;
  key.submap_id = in->get<std::int64_t>();
  key.x = get_coordinate(in);
  key.y = get_coordinate(in);
  key.z = get_coordinate(in);
  return key;
}

void put_place(const DenseSubmap& submap, NoteWriter* out) {
  out->pose(submap.T_map_submap);
  out->pose(submap.T_true_base);
  out->put(static_cast<std::int32_t>(submap.newer));
  out->put(static_cast<std::int32_t>(submap.visits));
}
void get_place(NoteReader* in, DenseSubmap* submap) {
  submap->T_map_submap = in->pose();
  submap->T_true_base = in->pose();
  submap->newer = in->get<std::int32_t>();
  submap->visits = in->get<std::int32_t>();
}

void put_content(const DenseSubmap& submap, NoteWriter* out) {
  out->put(static_cast<std::int32_t>(submap.n_keyframes));
  out->put(static_cast<std::uint32_t>(submap.packed.size()));
  for (const auto& [index, bytes] : submap.packed) {
    put_index(index, out);
    out->some(bytes);
  }
  out->put(static_cast<std::uint32_t>(submap.packed_cloud.size()));
  for (const auto& [key, bytes] : submap.packed_cloud) {
    put_key(key, out);
    out->some(bytes);
  }
  out->put(static_cast<std::uint32_t>(submap.surfaces.size()));
  for (const SurfacePoint& surface : submap.surfaces) {
    out->vector(surface.p_m);
    out->vector(surface.normal);
  }
  out->vector(submap.image_up_sum);
  out->put(static_cast<std::uint32_t>(submap.camera_positions_m.size()));
  for (const Eigen::Vector3d& p : submap.camera_positions_m) out->vector(p);
}
void get_content(NoteReader* in, DenseSubmap* submap) {
  submap->closed = true;
  submap->n_keyframes = in->get<std::int32_t>();
  for (std::size_t n = in->count(16); n > 0 && in->good(); --n) {
    const CubeIndex index = get_index(in);
    submap->packed[index] = in->some();
  }
  for (std::size_t n = in->count(24); n > 0 && in->good(); --n) {
    const TileKey key = get_key(in);
    submap->packed_cloud[key] = in->some();
  }
  for (std::size_t n = in->count(24); n > 0 && in->good(); --n) {
    const Eigen::Vector3f p_m = in->vector<float>();
    submap->surfaces.push_back({p_m, in->vector<float>()});
  }
  submap->image_up_sum = in->vector<double>();
  for (std::size_t n = in->count(24); n > 0 && in->good(); --n)
    submap->camera_positions_m.emplace_back(in->vector<double>());
}

void get_values(NoteReader* in, SavedValues* values) {
  values->resolution_m = in->get<double>();
  values->first_id = in->get<std::int64_t>();
  values->base_upto = in->get<std::int64_t>();
  values->newest_us = in->get<std::int64_t>();
  values->placed_us = in->get<std::int64_t>();
  values->level_keyframes = in->get<std::int64_t>();
  values->levelled = in->flag();
  values->floor_seen = in->flag();
  values->wish.reset();
  if (in->flag()) {
    LevelWish wish;
    wish.anchor_id = in->get<std::int64_t>();
    wish.T_level_anchor = in->pose();
    wish.floor_seen = in->flag();
    wish.utime_us = in->get<std::int64_t>();
    values->wish = wish;
  }
  MountingState mounting;
  mounting.n_floors = in->get<std::uint64_t>();
  mounting.off = in->flag();
  const auto floor = [in] {
    const Eigen::Vector3d v = in->vector<double>();
    return FloorPlane{v[0], v[1], v[2]};
  };
  mounting.used = floor();
  for (std::size_t n = in->count(24); n > 0 && in->good(); --n) mounting.floors.push_back(floor());
  if (in->good()) values->mounting = Mounting(mounting);
}

DenseSubmap& submap_at(std::int64_t id, SavedMap* map) {
  const double cloud_resolution_m = map->values.resolution_m / kCloudVoxelsPerCell;
  return map->submaps.try_emplace(id, cloud_resolution_m).first->second;
}

// Its keyframes are in it for good.
void close(std::int64_t submap_id, SavedMap* map) {
  for (auto it = map->open_keyframes.begin(); it != map->open_keyframes.end();) {
    if (it->second.submap_id == submap_id) {
      map->integrated.insert(it->first);
      it = map->open_keyframes.erase(it);
    } else {
      ++it;
    }
  }
}

void read_piece(std::uint8_t piece, NoteReader* in, SavedMap* map) {
  if (piece == kBaseCube) {
    const CubeIndex index = get_index(in);
    PackedBytes bytes = in->some();
    bytes.empty() ? void(map->base_cubes.erase(index))
                  : void(map->base_cubes[index] = std::move(bytes));
    return;
  }
  if (piece == kBaseCloud) {
    const TileKey key = get_key(in);
    PackedBytes bytes = in->some();
    bytes.empty() ? void(map->base_clouds.erase(key))
                  : void(map->base_clouds[key] = std::move(bytes));
    return;
  }
  if (piece == kDirtyBase) {
    map->dirty_base.clear();
    for (std::size_t n = in->count(12); n > 0 && in->good(); --n)
      map->dirty_base.insert(get_index(in));
    return;
  }
  const auto id = in->get<std::int64_t>();
  if (piece == kKeyframe) {
    SavedKeyframe keyframe;
    keyframe.submap_id = in->get<std::int64_t>();
    keyframe.T_submap_camera = in->pose();
    map->open_keyframes[id] = keyframe;
  } else if (piece == kIntegrated) {
    const auto last = in->get<std::int64_t>();
    map->integrated.insert_range(id, last);
  } else if (piece == kGoneSubmap) {
    map->submaps.erase(id);
    close(id, map);
  } else {
    if (piece == kWholeSubmap) map->submaps.erase(id);
    DenseSubmap& submap = submap_at(id, map);
    get_place(in, &submap);
    if (piece != kWholeSubmap) return;
    get_content(in, &submap);
    close(id, map);
  }
}

}  // namespace

void SavedMapWriter::values(const SavedValues& values) {
  NoteWriter out(&bytes_);
  out.put(std::uint8_t{kValues});
  out.put(values.resolution_m);
  for (const std::int64_t number : {values.first_id, values.base_upto, values.newest_us,
                                    values.placed_us, values.level_keyframes})
    out.put(number);
  out.put(static_cast<std::uint8_t>(values.levelled));
  out.put(static_cast<std::uint8_t>(values.floor_seen));
  out.put(static_cast<std::uint8_t>(values.wish.has_value()));
  if (values.wish) {
    out.put(values.wish->anchor_id);
    out.pose(values.wish->T_level_anchor);
    out.put(static_cast<std::uint8_t>(values.wish->floor_seen));
    out.put(values.wish->utime_us);
  }
  const MountingState mounting = values.mounting.state();
  out.put(static_cast<std::uint64_t>(mounting.n_floors));
  out.put(static_cast<std::uint8_t>(mounting.off));
  const auto floor = [&](const FloorPlane& plane) {
    out.vector(Eigen::Vector3d(plane.slope_x, plane.slope_y, plane.height_m));
  };
  floor(mounting.used);
  out.put(static_cast<std::uint32_t>(mounting.floors.size()));
  for (const FloorPlane& plane : mounting.floors) floor(plane);
}

void SavedMapWriter::keyframe(std::int64_t id, const SavedKeyframe& keyframe) {
  NoteWriter out(&bytes_);
  out.put(std::uint8_t{kKeyframe});
  out.put(id);
  out.put(keyframe.submap_id);
  out.pose(keyframe.T_submap_camera);
}

void SavedMapWriter::integrated(std::int64_t first, std::int64_t last) {
  NoteWriter out(&bytes_);
  out.put(std::uint8_t{kIntegrated});
  out.put(first);
  out.put(last);
}

void SavedMapWriter::whole_submap(std::int64_t id, const DenseSubmap& submap) {
  NoteWriter out(&bytes_);
  out.put(std::uint8_t{kWholeSubmap});
  out.put(id);
  put_place(submap, &out);
  put_content(submap, &out);
}

void SavedMapWriter::placed_submap(std::int64_t id, const DenseSubmap& submap) {
  NoteWriter out(&bytes_);
  out.put(std::uint8_t{kPlacedSubmap});
  out.put(id);
  put_place(submap, &out);
}

void SavedMapWriter::gone_submap(std::int64_t id) {
  NoteWriter out(&bytes_);
  out.put(std::uint8_t{kGoneSubmap});
  out.put(id);
}

void SavedMapWriter::base_cube(const CubeIndex& index, const PackedBytes& bytes) {
  NoteWriter out(&bytes_);
  out.put(std::uint8_t{kBaseCube});
  put_index(index, &out);
  out.some(bytes);
}

void SavedMapWriter::base_cloud(const TileKey& key, const PackedBytes& bytes) {
  NoteWriter out(&bytes_);
  out.put(std::uint8_t{kBaseCloud});
  put_key(key, &out);
  out.some(bytes);
}

void SavedMapWriter::dirty_base(const std::set<CubeIndex>& cubes) {
  NoteWriter out(&bytes_);
  out.put(std::uint8_t{kDirtyBase});
  out.put(static_cast<std::uint32_t>(cubes.size()));
  for (const CubeIndex& index : cubes) put_index(index, &out);
}

SavedBytes SavedMapWriter::take() {
  if (bytes_.empty()) return {};
  bytes_.insert(bytes_.begin(), kVersion);
  return std::exchange(bytes_, {});
}

bool read_saved(const std::uint8_t* bytes, std::size_t size_bytes, SavedMap* map) {
  NoteReader in(bytes, size_bytes);
  if (in.get<std::uint8_t>() != kVersion) return false;
  while (in.more()) {
    const auto piece = in.get<std::uint8_t>();
    if (piece < kValues || piece > kDirtyBase) return false;
    if (piece == kValues)
      get_values(&in, &map->values);
    else
      read_piece(piece, &in, map);
  }
  return in.good();
}

}  // namespace fusion_slam
