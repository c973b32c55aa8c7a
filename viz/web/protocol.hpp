// The bytes between viewer and page (docs/viewer.md has the tables): batches of items to the
// browser, requests from it. Pure functions, any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "libs/tiles/tile.hpp"
#include "viz/web/item_store.hpp"

namespace fusion_slam {

// Little-endian numbers one after another.
class ByteWriter {
 public:
  ByteWriter& u8(std::uint8_t value);
  ByteWriter& u16(std::uint16_t value);
  ByteWriter& u32(std::uint32_t value);
  ByteWriter& i32(std::int32_t value);
  ByteWriter& f32(double value);
  ByteWriter& f64(double value);
  ByteWriter& pose(const SE3& T);  // 7 f32: x, y, z (m), quaternion w, x, y, z
  ByteWriter& bytes(std::string_view data);
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

// One WebSocket message: u8 1, u32 number of the batch (the browser acknowledges it), u32 epoch;
// then for each item u8 topic, u8 1 when it is gone, u16 bytes of the key, u32 bytes of the
// payload, key, payload.
std::string encode_batch(std::uint32_t number, std::uint64_t epoch, const std::vector<Item>& items);

// A map tile: f64 utime (us), i32 x, y, z, f64 resolution (m), i32 size_cells, u8 encoding, zlib
// data as in docs/tiles.md.
std::string encode_tile(const Tile& tile);

// "fused", "cloud" ...: the name of a topic in a request; nothing for an unknown one.
std::optional<Topic> topic_from(std::string_view name);
std::string_view name_of(Topic topic);

// What a browser may ask for.
struct Request {
  enum class Kind { kAck, kWant, kCell, kCommand, kReplay };
  Kind kind = Kind::kAck;
  std::int64_t id = 0;      // of kCell, kCommand and kReplay: repeated in the answer
  std::uint32_t batch = 0;  // kAck
  TopicSet topics;          // kWant
  double x_m = 0.0;         // kCell, kCommand localise: map frame
  double y_m = 0.0;
  double yaw_rad = 0.0;
  std::string verb;    // kCommand: save_map, reset, localise, start, stop, restart; kReplay: play,
                       // pause, seek, speed
  std::string target;  // kCommand start, stop, restart: command of the sheriff
  double value = 0.0;  // kReplay: seek (s since the beginning), speed (1: as recorded)
};

constexpr std::size_t kMaxRequestBytes = 4096;

// Nothing, with a reason for people in `why`, for anything that is not exactly a request. Never
// throws, whatever comes.
std::optional<Request> parse_request(std::string_view text, std::string* why);

}  // namespace fusion_slam
