#include "services/dense_mapper/saved_map.hpp"

#include <cmath>
#include <cstring>
#include <type_traits>

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
};

// Numbers as this machine has them in memory (little-endian on all that we run on): a journal is
// read where it was written.
class Out {
 public:
  explicit Out(SavedBytes* bytes) : bytes_(bytes) {}

  template <class Number>
  void put(Number number) {
    static_assert(std::is_arithmetic<Number>::value);
    const std::size_t at = bytes_->size();
    bytes_->resize(at + sizeof number);
    std::memcpy(bytes_->data() + at, &number, sizeof number);
  }
  void pose(const SE3& T) {
    for (int i = 0; i < 12; ++i) put(T.matrix()(i % 3, i / 3));
  }
  template <class Vector>
  void vector(const Vector& v) {
    for (int i = 0; i < 3; ++i) put(v[i]);
  }
  void some(const PackedBytes& some) {
    put(static_cast<std::uint32_t>(some.size()));
    bytes_->insert(bytes_->end(), some.begin(), some.end());
  }

 private:
  SavedBytes* bytes_;
};

class In {
 public:
  In(const std::uint8_t* bytes, std::size_t size_bytes) : at_(bytes), left_(size_bytes) {}

  template <class Number>
  Number get() {
    Number number{};
    if (left_ < sizeof number) {
      good_ = false;
      left_ = 0;
      return number;
    }
    std::memcpy(&number, at_, sizeof number);
    at_ += sizeof number;
    left_ -= sizeof number;
    return number;
  }
  bool flag() { return get<std::uint8_t>() != 0; }
  SE3 pose() {
    SE3 T = SE3::Identity();
    for (int i = 0; i < 12; ++i) T.matrix()(i % 3, i / 3) = finite(get<double>());
    return T;
  }
  template <class Number>
  Eigen::Matrix<Number, 3, 1> vector() {
    Eigen::Matrix<Number, 3, 1> v;
    for (int i = 0; i < 3; ++i) v[i] = static_cast<Number>(finite(get<Number>()));
    return v;
  }
  PackedBytes some() {
    const std::size_t size = count(1);
    PackedBytes bytes(at_, at_ + size);
    at_ += size;
    left_ -= size;
    return bytes;
  }
  // How many things of at least so many bytes follow: never more than there is room for.
  std::size_t count(std::size_t each_bytes) {
    const std::size_t n = get<std::uint32_t>();
    if (n * each_bytes <= left_) return n;
    good_ = false;
    return 0;
  }
  bool good() const { return good_; }
  bool more() const { return good_ && left_ > 0; }

 private:
  double finite(double value) {
    good_ = good_ && std::isfinite(value);
    return value;
  }
  const std::uint8_t* at_;
  std::size_t left_;
  bool good_ = true;
};

void put_index(const CubeIndex& index, Out* out) {
  out->put(index.x);
  out->put(index.y);
  out->put(index.z);
}
CubeIndex get_index(In* in) {
  const int x = in->get<int>();
  const int y = in->get<int>();
  return {x, y, in->get<int>()};
}

void put_key(const TileKey& key, Out* out) {
  out->put(key.submap_id);
  out->put(key.x);
  out->put(key.y);
  out->put(key.z);
}
TileKey get_key(In* in) {
  TileKey key;
  key.submap_id = in->get<std::int64_t>();
  key.x = in->get<std::int32_t>();
  key.y = in->get<std::int32_t>();
  key.z = in->get<std::int32_t>();
  return key;
}

void put_place(const DenseSubmap& submap, Out* out) {
  out->pose(submap.T_map_submap);
  out->pose(submap.T_true_base);
  out->put(static_cast<std::int32_t>(submap.newer));
  out->put(static_cast<std::int32_t>(submap.visits));
}
void get_place(In* in, DenseSubmap* submap) {
  submap->T_map_submap = in->pose();
  submap->T_true_base = in->pose();
  submap->newer = in->get<std::int32_t>();
  submap->visits = in->get<std::int32_t>();
}

void put_content(const DenseSubmap& submap, Out* out) {
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
void get_content(In* in, DenseSubmap* submap) {
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

void get_values(In* in, SavedValues* values) {
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

void read_piece(std::uint8_t piece, In* in, SavedMap* map) {
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
  Out out(&bytes_);
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
  Out out(&bytes_);
  out.put(std::uint8_t{kKeyframe});
  out.put(id);
  out.put(keyframe.submap_id);
  out.pose(keyframe.T_submap_camera);
}

void SavedMapWriter::integrated(std::int64_t first, std::int64_t last) {
  Out out(&bytes_);
  out.put(std::uint8_t{kIntegrated});
  out.put(first);
  out.put(last);
}

void SavedMapWriter::whole_submap(std::int64_t id, const DenseSubmap& submap) {
  Out out(&bytes_);
  out.put(std::uint8_t{kWholeSubmap});
  out.put(id);
  put_place(submap, &out);
  put_content(submap, &out);
}

void SavedMapWriter::placed_submap(std::int64_t id, const DenseSubmap& submap) {
  Out out(&bytes_);
  out.put(std::uint8_t{kPlacedSubmap});
  out.put(id);
  put_place(submap, &out);
}

void SavedMapWriter::gone_submap(std::int64_t id) {
  Out out(&bytes_);
  out.put(std::uint8_t{kGoneSubmap});
  out.put(id);
}

void SavedMapWriter::base_cube(const CubeIndex& index, const PackedBytes& bytes) {
  Out out(&bytes_);
  out.put(std::uint8_t{kBaseCube});
  put_index(index, &out);
  out.some(bytes);
}

void SavedMapWriter::base_cloud(const TileKey& key, const PackedBytes& bytes) {
  Out out(&bytes_);
  out.put(std::uint8_t{kBaseCloud});
  put_key(key, &out);
  out.some(bytes);
}

SavedBytes SavedMapWriter::take() {
  if (bytes_.empty()) return {};
  bytes_.insert(bytes_.begin(), kVersion);
  return std::exchange(bytes_, {});
}

bool read_saved(const std::uint8_t* bytes, std::size_t size_bytes, SavedMap* map) {
  In in(bytes, size_bytes);
  if (in.get<std::uint8_t>() != kVersion) return false;
  while (in.more()) {
    const auto piece = in.get<std::uint8_t>();
    if (piece < kValues || piece > kBaseCloud) return false;
    if (piece == kValues)
      get_values(&in, &map->values);
    else
      read_piece(piece, &in, map);
  }
  return in.good();
}

}  // namespace fusion_slam
