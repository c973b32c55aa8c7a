#include "drivers/simulator/world.hpp"

#include <cmath>

#include "drivers/simulator/furniture.hpp"
#include "drivers/simulator/gazebo_world.hpp"
#include "drivers/simulator/mesh_file.hpp"
#include "drivers/simulator/route.hpp"
#include "drivers/simulator/texture.hpp"
#include "drivers/simulator/truth_class.hpp"
#include "drivers/simulator/yaml_section.hpp"

namespace fusion_slam {
namespace {

// `seed` makes every thing's pattern its own.
Material read_material(const YamlSection& s, TextureKind otherwise, std::uint64_t seed) {
  Material m;
  m.kind = s.has("texture") ? *texture_from(s.word("texture", texture_names())) : otherwise;
  m.bgr = default_colour(m.kind);
  // Things of one pattern look the same; others' seeds stay far below.
  m.seed = s.has("pattern")
               ? 1'000'000'000 + static_cast<std::uint64_t>(s.number("pattern", 0.0, 1e9, 0.0))
               : seed;
  if (s.has("colour")) {
    const auto rgb = s.numbers(s.child("colour"), "colour", 3, 3);
    for (std::size_t k = 0; k < 3; ++k) m.bgr[k] = static_cast<float>(rgb[2 - k] / 255.0);
  }
  return m;
}

ObstacleClass read_class(const YamlSection& s, ObstacleClass otherwise) {
  if (!s.has("class")) return otherwise;
  std::vector<std::string> names;
  for (std::size_t i = 1; i < kObstacleClasses; ++i) names.emplace_back(kObstacleClassNames[i]);
  return *obstacle_class_from(s.word("class", names));
}

// Boxes of a thing from `first` on must have a volume: nothing can be seen of others.
void require_volume(const YamlSection& s, const YAML::Node& at, const std::string& what,
                    std::size_t first, const std::vector<Box>& boxes) {
  for (std::size_t i = first; i < boxes.size(); ++i)
    if (!(boxes[i].half_m.minCoeff() > 0.0)) s.fail(at, what);
}

void set_class(ObstacleClass obstacle, std::size_t first, std::vector<Box>* boxes) {
  for (std::size_t i = first; i < boxes->size(); ++i) (*boxes)[i].obstacle = obstacle;
}

void add_wall(const YamlSection& s, std::uint64_t seed, std::vector<Box>* boxes) {
  const auto from = s.numbers(s.child("from"), "from", 2, 2);
  const auto to = s.numbers(s.child("to"), "to", 2, 2);
  const double dx = to[0] - from[0], dy = to[1] - from[1];
  const Eigen::Vector3d size(std::hypot(dx, dy), s.number("thickness_m", 0.005, 2.0, 0.12),
                             s.number("height_m", 0.05, 20.0, 2.6));
  const Eigen::Vector3d at(0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]),
                           s.number("base_m", -1.0, 20.0, 0.0));
  boxes->push_back(
      standing_box(at, std::atan2(dy, dx), size, read_material(s, TextureKind::kPlaster, seed)));
  set_class(read_class(s, ObstacleClass::kWall), boxes->size() - 1, boxes);
  require_volume(s, s.child("to"), "the wall ends where it begins", boxes->size() - 1, *boxes);
}

void add_thing(const YamlSection& s, std::uint64_t seed, std::vector<Box>* boxes) {
  const std::string kind = s.word("kind", {"box", "desk", "table", "chair", "picture", "mesh"});
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
        read_material(s, TextureKind::kWood, seed), boxes);
  if (kind == "table")
    add_table(
        foot, yaw,
        size.empty() ? Eigen::Vector3d(1.1, 0.6, 0.45) : Eigen::Vector3d(size[0], size[1], size[2]),
        read_material(s, TextureKind::kWood, seed), boxes);
  if (kind == "chair") add_chair(foot, yaw, read_material(s, TextureKind::kFabric, seed), boxes);
  if (kind == "picture")
    boxes->push_back(standing_box(foot, yaw, {0.012, size[0], size[1]},
                                  read_material(s, TextureKind::kPoster, seed)));
  if (kind == "box")
    boxes->push_back(standing_box(foot, yaw, {size[0], size[1], size[2]},
                                  read_material(s, TextureKind::kCardboard, seed)));
  const ObstacleClass otherwise = kind == "desk" || kind == "table" ? ObstacleClass::kTable
                                  : kind == "chair"                 ? ObstacleClass::kChair
                                  : kind == "picture"               ? ObstacleClass::kWall
                                                                    : ObstacleClass::kOther;
  set_class(read_class(s, otherwise), first, boxes);
  if (!size.empty())
    require_volume(s, s.child("size_m"), "'size_m' is too small for a " + kind, first, *boxes);
}

// A model from a file beside the world file.
void add_model(const YamlSection& s, MeshFiles* files, World* world) {
  auto at = s.numbers(s.child("at"), "at", 2, 3);
  at.resize(3, 0.0);
  const double yaw = s.number("yaw_deg", -360.0, 360.0, 0.0) * M_PI / 180.0;
  const double scale = s.number("scale", 1e-4, 1e4, 1.0);
  const std::string name = s.text("file");
  if (name.empty()) s.fail(s.node(), "'file' of the mesh is missing");
  const auto path = std::filesystem::path(s.file()).parent_path() / name;
  if (!std::filesystem::is_regular_file(path))
    s.fail(s.child("file"), "'file' is " + path.string() + ", and there is no such file");
  for (const Mesh& mesh : files->load(path)) {
    world->meshes.push_back(placed(mesh, from_xyz_rpy(at[0], at[1], at[2], 0.0, 0.0, yaw),
                                   Eigen::Vector3d::Constant(scale)));
    world->meshes.back().name = path.stem().string();
    world->meshes.back().obstacle = read_class(s, class_of_model(path.stem().string()));
  }
}

World read_world(const YAML::Node& root, const std::string& file) {
  const YamlSection s(root, file, {"name", "route", "limits", "lamps", "things", "walls"});
  World world;
  world.name = s.text("name");
  world.route_m = read_way_points(s);
  world.limits = read_limits(s);
  for (const auto& item : s.list("lamps")) {
    const auto xyz = s.numbers(item, "lamps", 3, 3);
    world.lighting.lamps_m.emplace_back(xyz[0], xyz[1], xyz[2]);
  }
  std::uint64_t seed = 1;  // patterns belong to the world, not to a run
  for (const auto& item : s.list("walls"))
    add_wall(YamlSection(item, file,
                         {"from", "to", "height_m", "thickness_m", "base_m", "texture", "colour",
                          "class", "pattern"}),
             ++seed, &world.boxes);
  MeshFiles files;
  for (const auto& item : s.list("things")) {
    const YamlSection thing(item, file,
                            {"kind", "at", "yaw_deg", "size_m", "texture", "colour", "class",
                             "pattern", "file", "scale"});
    if (thing.text("kind") == "mesh")
      add_model(thing, &files, &world);
    else
      add_thing(thing, ++seed, &world.boxes);
  }
  world.warnings = files.warnings();
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
  const std::string kind = path.extension().string();
  if (kind == ".world" || kind == ".sdf") return load_gazebo_world(path);
  return world_from_text(text_of_file(path), path.string());
}

}  // namespace fusion_slam
