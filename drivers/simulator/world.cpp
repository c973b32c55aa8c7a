#include "drivers/simulator/world.hpp"

#include <cmath>
#include <fstream>
#include <sstream>

#include "drivers/simulator/furniture.hpp"
#include "drivers/simulator/texture.hpp"
#include "libs/config/yaml_map.hpp"

namespace fusion_slam {
namespace {

// A map of the file whose every key must be known.
class Section {
 public:
  Section(const YAML::Node& node, std::string file, const std::vector<std::string>& keys)
      : node_(node), file_(std::move(file)) {
    if (!node_.IsMap()) fail(node_, "expected {key: value, ...}");
    for (const auto& item : node_) {
      const auto key = item.first.IsScalar() ? item.first.Scalar() : std::string("?");
      bool known = false;
      for (const std::string& k : keys) known = known || k == key;
      if (!known)
        fail(item.first,
             "unknown key '" + key + "'; the nearest valid key is '" + nearest(key, keys) + "'");
    }
  }

  [[noreturn]] void fail(const YAML::Node& at, const std::string& what) const {
    throw ConfigError(file_ + ":" + std::to_string(at.Mark().line + 1) + ": " + what);
  }
  bool has(const std::string& key) const { return node_[key].IsDefined(); }
  YAML::Node child(const std::string& key) const {
    if (!has(key)) fail(node_, "'" + key + "' is missing");
    return node_[key];
  }
  std::vector<YAML::Node> list(const std::string& key) const {
    std::vector<YAML::Node> items;
    if (!has(key)) return items;
    if (!node_[key].IsSequence()) fail(node_[key], "'" + key + "' must be a list");
    for (const auto& item : node_[key]) items.push_back(item);
    return items;
  }
  std::vector<double> numbers(const YAML::Node& at, const std::string& key, std::size_t least,
                              std::size_t most) const {
    std::vector<double> values;
    if (at.IsSequence())
      for (const auto& item : at) {
        double value = NAN;
        if (!item.IsScalar() || !YAML::convert<double>::decode(item, value) ||
            !(std::fabs(value) < 1e4))
          fail(at, "'" + key + "' must hold numbers");
        values.push_back(value);
      }
    if (values.size() < least || values.size() > most)
      fail(at, "'" + key + "' must be a list of " + std::to_string(least) +
                   (most > least ? " or " + std::to_string(most) : "") + " numbers");
    return values;
  }
  double number(const std::string& key, double low, double high, double otherwise) const {
    if (!has(key)) return otherwise;
    double value = NAN;
    if (!node_[key].IsScalar() || !YAML::convert<double>::decode(node_[key], value) ||
        !(value >= low && value <= high))
      fail(node_[key], "'" + key + "' must be a number from " + std::to_string(low) + " to " +
                           std::to_string(high));
    return value;
  }
  std::string word(const std::string& key, const std::vector<std::string>& choices) const {
    const YAML::Node at = child(key);
    std::string value = at.IsScalar() ? at.Scalar() : "";
    for (const std::string& c : choices)
      if (c == value) return value;
    fail(at, "'" + key + "' is '" + value + "'; the nearest valid value is '" +
                 nearest(value, choices) + "'");
  }
  std::string text(const std::string& key) const { return has(key) ? child(key).Scalar() : ""; }

  // `seed` makes every thing's pattern its own.
  Material material(TextureKind otherwise, std::uint64_t seed) const {
    Material m;
    m.kind = has("texture") ? *texture_from(word("texture", texture_names())) : otherwise;
    m.bgr = default_colour(m.kind);
    m.seed = seed;
    if (has("colour")) {
      const auto rgb = numbers(child("colour"), "colour", 3, 3);
      for (std::size_t k = 0; k < 3; ++k) m.bgr[k] = static_cast<float>(rgb[2 - k] / 255.0);
    }
    return m;
  }

 private:
  YAML::Node node_;
  std::string file_;
};

// Boxes of a thing from `first` on must have a volume: nothing can be seen of others.
void require_volume(const Section& s, const YAML::Node& at, const std::string& what,
                    std::size_t first, const std::vector<Box>& boxes) {
  for (std::size_t i = first; i < boxes.size(); ++i)
    if (!(boxes[i].half_m.minCoeff() > 0.0)) s.fail(at, what);
}

void add_wall(const Section& s, std::uint64_t seed, std::vector<Box>* boxes) {
  const auto from = s.numbers(s.child("from"), "from", 2, 2);
  const auto to = s.numbers(s.child("to"), "to", 2, 2);
  const double dx = to[0] - from[0], dy = to[1] - from[1];
  const Eigen::Vector3d size(std::hypot(dx, dy), s.number("thickness_m", 0.005, 2.0, 0.12),
                             s.number("height_m", 0.05, 20.0, 2.6));
  const Eigen::Vector3d at(0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]),
                           s.number("base_m", -1.0, 20.0, 0.0));
  boxes->push_back(
      standing_box(at, std::atan2(dy, dx), size, s.material(TextureKind::kPlaster, seed)));
  require_volume(s, s.child("to"), "the wall ends where it begins", boxes->size() - 1, *boxes);
}

void add_thing(const Section& s, std::uint64_t seed, std::vector<Box>* boxes) {
  const std::string kind = s.word("kind", {"box", "desk", "chair", "picture"});
  auto at = s.numbers(s.child("at"), "at", 2, 3);
  at.resize(3, 0.0);
  const Eigen::Vector3d foot(at[0], at[1], at[2]);
  const double yaw = s.number("yaw_deg", -360.0, 360.0, 0.0) * M_PI / 180.0;
  std::vector<double> size;
  if (kind == "picture" || kind == "box" || s.has("size_m")) {
    const std::size_t n = kind == "picture" ? 2 : 3;
    size = s.numbers(s.child("size_m"), "size_m", n, n);
    for (const double length : size)
      if (!(length > 0.0)) s.fail(s.child("size_m"), "'size_m' must be above 0");
  }
  const std::size_t first = boxes->size();
  if (kind == "desk")
    add_desk(
        foot, yaw,
        size.empty() ? Eigen::Vector3d(1.4, 0.7, 0.74) : Eigen::Vector3d(size[0], size[1], size[2]),
        s.material(TextureKind::kWood, seed), boxes);
  if (kind == "chair") add_chair(foot, yaw, s.material(TextureKind::kFabric, seed), boxes);
  if (kind == "picture")
    boxes->push_back(
        standing_box(foot, yaw, {0.012, size[0], size[1]}, s.material(TextureKind::kPoster, seed)));
  if (kind == "box")
    boxes->push_back(standing_box(foot, yaw, {size[0], size[1], size[2]},
                                  s.material(TextureKind::kCardboard, seed)));
  if (!size.empty())
    require_volume(s, s.child("size_m"), "'size_m' is too small for a " + kind, first, *boxes);
}

World read_world(const YAML::Node& root, const std::string& file) {
  const Section s(root, file, {"name", "route", "limits", "lamps", "things", "walls"});
  World world;
  world.name = s.text("name");
  for (const auto& item : s.list("route")) {
    const auto xy = s.numbers(item, "route", 2, 2);
    world.route_m.emplace_back(xy[0], xy[1]);
  }
  if (world.route_m.size() < 2) s.fail(root, "'route' needs two or more way points [x, y]");
  if (s.has("limits")) {
    const Section l(s.child("limits"), file,
                    {"speed_m_s", "turn_rad_s", "accel_m_s2", "turn_accel_rad_s2"});
    DriveLimits& limits = world.limits;
    limits.max_speed_m_s = l.number("speed_m_s", 0.05, 3.0, limits.max_speed_m_s);
    limits.max_turn_rad_s = l.number("turn_rad_s", 0.05, 6.0, limits.max_turn_rad_s);
    limits.max_accel_m_s2 = l.number("accel_m_s2", 0.05, 10.0, limits.max_accel_m_s2);
    limits.max_turn_accel_rad_s2 =
        l.number("turn_accel_rad_s2", 0.05, 30.0, limits.max_turn_accel_rad_s2);
  }
  for (const auto& item : s.list("lamps")) {
    const auto xyz = s.numbers(item, "lamps", 3, 3);
    world.lighting.lamps_m.emplace_back(xyz[0], xyz[1], xyz[2]);
  }
  std::uint64_t seed = 1;  // patterns belong to the world, not to a run
  for (const auto& item : s.list("walls"))
    add_wall(Section(item, file,
                     {"from", "to", "height_m", "thickness_m", "base_m", "texture", "colour"}),
             ++seed, &world.boxes);
  for (const auto& item : s.list("things"))
    add_thing(Section(item, file, {"kind", "at", "yaw_deg", "size_m", "texture", "colour"}), ++seed,
              &world.boxes);
  return world;
}

}  // namespace

World world_from_text(const std::string& text, const std::string& file_name) {
  try {
    return read_world(YAML::Load(text), file_name);
  } catch (const YAML::Exception& error) {
    throw ConfigError(file_name + ":" + std::to_string(error.mark.line + 1) +
                      ": not valid YAML: " + error.msg);
  }
}

World load_world(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  if (!std::filesystem::is_regular_file(path) || !(text << file.rdbuf()))
    throw ConfigError(path.string() + ": cannot be read, or is empty; check the path");
  return world_from_text(text.str(), path.string());
}

}  // namespace fusion_slam
