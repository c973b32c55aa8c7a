#include "viz/web/protocol.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <nlohmann/json.hpp>

namespace fusion_slam {
namespace {

using Json = nlohmann::json;

constexpr std::array<std::string_view, kTopics> kNames{
    "time",  "notice", "robot", "pose",  "health", "input",    "deputy", "scan",    "loop",
    "nodes", "truth",  "fused", "lidar", "visual", "keyframe", "camera", "octomap", "cloud"};

template <class Integer>
void append(std::string& out, Integer value) {
  for (std::size_t i = 0; i < sizeof(value); ++i)
    out.push_back(static_cast<char>(static_cast<unsigned char>(value >> (8 * i))));
}

constexpr double kFarthest_m = 1e6;
constexpr double kFarthest_s = 1e9;

// A member that has to be a finite number within +-most.
bool number(const Json& json, const char* name, double most, double* out, std::string* why) {
  const auto member = json.find(name);
  if (member != json.end() && member->is_number()) {
    *out = member->get<double>();
    if (std::isfinite(*out) && std::abs(*out) <= most) return true;
  }
  *why = std::string("\"") + name + "\" has to be a number within " + std::to_string(most);
  return false;
}

bool word(const Json& json, const char* name, std::initializer_list<const char*> allowed,
          std::string* out, std::string* why) {
  const auto member = json.find(name);
  if (member != json.end() && member->is_string()) {
    *out = member->get<std::string>();
    if (std::find(allowed.begin(), allowed.end(), *out) != allowed.end()) return true;
  }
  *why = std::string("\"") + name + "\" has to be one of";
  for (const char* one : allowed) *why += std::string(" ") + one;
  return false;
}

bool wanted_topics(const Json& json, TopicSet* topics, std::string* why) {
  const auto names = json.find("topics");
  *why = "\"topics\" has to be a list of topics' names";
  if (names == json.end() || !names->is_array()) return false;
  for (const Json& name : *names) {
    const auto topic =
        name.is_string() ? topic_from(name.get_ref<const std::string&>()) : std::optional<Topic>();
    if (!topic) return false;
    topics->set(static_cast<std::size_t>(*topic));
  }
  return true;
}

bool command_members(const Json& json, Request* request, std::string* why) {
  if (!word(json, "verb", {"save_map", "reset", "localise", "start", "stop", "restart"},
            &request->verb, why))
    return false;
  if (request->verb == "localise")
    return number(json, "x", kFarthest_m, &request->x_m, why) &&
           number(json, "y", kFarthest_m, &request->y_m, why) &&
           number(json, "yaw", 7.0, &request->yaw_rad, why);
  if (request->verb == "save_map" || request->verb == "reset") return true;
  const auto target = json.find("target");
  *why = "\"target\" has to be the name of a process, 1 to 200 characters, no hyphen first";
  if (target == json.end() || !target->is_string()) return false;
  request->target = target->get<std::string>();
  return !request->target.empty() && request->target.size() <= 200 && request->target[0] != '-';
}

bool replay_members(const Json& json, Request* request, std::string* why) {
  if (!word(json, "verb", {"play", "pause", "seek", "speed"}, &request->verb, why)) return false;
  if (request->verb == "seek") return number(json, "value", kFarthest_s, &request->value, why);
  if (request->verb != "speed") return true;
  if (!number(json, "value", 100.0, &request->value, why)) return false;
  *why = "a speed is between 0.1 and 100";
  return request->value >= 0.1;
}

}  // namespace

ByteWriter& ByteWriter::u8(std::uint8_t value) { return append(bytes_, value), *this; }
ByteWriter& ByteWriter::u16(std::uint16_t value) { return append(bytes_, value), *this; }
ByteWriter& ByteWriter::u32(std::uint32_t value) { return append(bytes_, value), *this; }
ByteWriter& ByteWriter::i32(std::int32_t value) { return u32(static_cast<std::uint32_t>(value)); }

ByteWriter& ByteWriter::f32(double value) {
  const auto narrow = static_cast<float>(value);
  std::uint32_t bits = 0;
  std::memcpy(&bits, &narrow, sizeof(bits));
  return u32(bits);
}

ByteWriter& ByteWriter::f64(double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof(bits));
  return append(bytes_, bits), *this;
}

ByteWriter& ByteWriter::pose(const SE3& T) {
  const Eigen::Quaterniond q(T.linear());
  return f32(T.translation().x())
      .f32(T.translation().y())
      .f32(T.translation().z())
      .f32(q.w())
      .f32(q.x())
      .f32(q.y())
      .f32(q.z());
}

ByteWriter& ByteWriter::bytes(std::string_view data) { return bytes_.append(data), *this; }

std::string encode_batch(std::uint32_t number, std::uint64_t epoch,
                         const std::vector<Item>& items) {
  ByteWriter out;
  out.u8(1).u32(number).u32(static_cast<std::uint32_t>(epoch));
  for (const Item& item : items) {
    const std::string_view payload = item.payload ? std::string_view(*item.payload) : "";
    out.u8(static_cast<std::uint8_t>(item.topic)).u8(item.payload ? 0 : 1);
    out.u16(static_cast<std::uint16_t>(item.key.size()));
    out.u32(static_cast<std::uint32_t>(payload.size())).bytes(item.key).bytes(payload);
  }
  return out.take();
}

std::string encode_tile(const Tile& tile) {
  ByteWriter out;
  out.f64(static_cast<double>(tile.utime_us)).i32(tile.key.x).i32(tile.key.y).i32(tile.key.z);
  out.f64(tile.resolution_m).i32(tile.size_cells).u8(static_cast<std::uint8_t>(tile.encoding));
  return out.bytes({reinterpret_cast<const char*>(tile.data.data()), tile.data.size()}).take();
}

std::optional<Topic> topic_from(std::string_view name) {
  const auto* const found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Topic>(found - kNames.begin());
}

std::string_view name_of(Topic topic) { return kNames.at(static_cast<std::size_t>(topic)); }

std::optional<Request> parse_request(std::string_view text, std::string* why) {
  *why = "longer than " + std::to_string(kMaxRequestBytes) + " bytes";
  if (text.size() > kMaxRequestBytes) return std::nullopt;
  const Json json = Json::parse(text.begin(), text.end(), nullptr, false);
  *why = "not a JSON object";
  if (!json.is_object()) return std::nullopt;
  Request request;
  std::string type;
  if (!word(json, "type", {"ack", "want", "cell", "command", "replay"}, &type, why))
    return std::nullopt;
  double whole = 0.0;
  if (type == "ack") {
    request.kind = Request::Kind::kAck;
    if (!number(json, "batch", 4294967295.0, &whole, why)) return std::nullopt;
    *why = "\"batch\" has to be positive";
    if (whole < 0.0) return std::nullopt;
    request.batch = static_cast<std::uint32_t>(whole);
    return request;
  }
  if (type == "want") {
    request.kind = Request::Kind::kWant;
    return wanted_topics(json, &request.topics, why) ? std::optional(request) : std::nullopt;
  }
  if (!number(json, "id", 1e9, &whole, why)) return std::nullopt;
  request.id = static_cast<std::int64_t>(whole);
  bool good = false;
  if (type == "cell") {
    request.kind = Request::Kind::kCell;
    good = number(json, "x", kFarthest_m, &request.x_m, why) &&
           number(json, "y", kFarthest_m, &request.y_m, why);
  } else if (type == "command") {
    request.kind = Request::Kind::kCommand;
    good = command_members(json, &request, why);
  } else {
    request.kind = Request::Kind::kReplay;
    good = replay_members(json, &request, why);
  }
  return good ? std::optional(request) : std::nullopt;
}

}  // namespace fusion_slam
