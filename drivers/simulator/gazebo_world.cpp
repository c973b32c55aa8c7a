#include "drivers/simulator/gazebo_world.hpp"

#include <cstdlib>
#include <sstream>

#include <tinyxml2.h>

#include "drivers/simulator/mesh_file.hpp"
#include "drivers/simulator/mesh_shapes.hpp"
#include "drivers/simulator/truth_class.hpp"
#include "libs/config/yaml_map.hpp"

namespace fusion_slam {
namespace {

using tinyxml2::XMLElement;
constexpr int kDeepest = 8;         // models within models
constexpr double kLargestM = 40.0;  // of a plane, which has no end

std::string text_of(const XMLElement* element) {
  if (element == nullptr || element->GetText() == nullptr) return "";
  std::string text = element->GetText();
  const auto first = text.find_first_not_of(" \t\r\n"), last = text.find_last_not_of(" \t\r\n");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

std::vector<std::filesystem::path> model_folders(const std::filesystem::path& world) {
  std::vector<std::filesystem::path> folders;
  if (const char* list = std::getenv("GAZEBO_MODEL_PATH")) {
    std::istringstream in(list);
    for (std::string folder; std::getline(in, folder, ':');)
      if (!folder.empty()) folders.emplace_back(folder);
  }
  const auto beside = std::filesystem::absolute(world).parent_path();
  for (const auto& at : {beside, beside.parent_path()}) {
    folders.push_back(at / "models");
    folders.push_back(at);
  }
  return folders;
}

class Reader {
 public:
  explicit Reader(std::filesystem::path file)
      : file_(std::move(file)), folders_(model_folders(file_)) {}

  World read() {
    tinyxml2::XMLDocument document;
    load(file_, &document);
    const XMLElement* sdf = document.FirstChildElement("sdf");
    const XMLElement* world = sdf == nullptr ? nullptr : sdf->FirstChildElement("world");
    if (world == nullptr)
      throw ConfigError(file_.string() + ": not a Gazebo world: it has no <sdf><world>");
    if (const char* name = world->Attribute("name")) world_.name = name;
    world_.lighting.lamp_power = kLampPower;
    read_sky(world->FirstChildElement("scene"));
    things(*world, file_, SE3::Identity(), "", 0);
    for (const std::string& warning : files_.warnings()) world_.warnings.push_back(warning);
    return std::move(world_);
  }

 private:
  static constexpr double kLampPower = 1.2;  // of a lamp whose diffuse colour is 0.5

  static void load(const std::filesystem::path& file, tinyxml2::XMLDocument* document) {
    if (document->LoadFile(file.c_str()) != tinyxml2::XML_SUCCESS)
      throw ConfigError(file.string() + ": cannot be read as XML: " + document->ErrorStr());
  }
  void warn(const std::filesystem::path& file, const XMLElement& at, const std::string& what) {
    world_.warnings.push_back(file.string() + ":" + std::to_string(at.GetLineNum()) + ": " + what);
  }
  // n numbers; false with a warning when there are others.
  bool numbers(const std::filesystem::path& file, const XMLElement& at, std::size_t n,
               std::vector<double>* values) {
    std::istringstream in(text_of(&at));
    values->assign(n, 0.0);
    for (double& value : *values)
      if (!(in >> value) || !(std::fabs(value) < 1e4)) {
        warn(file, at, std::string("<") + at.Name() + "> needs " + std::to_string(n) + " numbers");
        return false;
      }
    return true;
  }
  SE3 pose(const std::filesystem::path& file, const XMLElement& of) {
    const XMLElement* at = of.FirstChildElement("pose");
    std::vector<double> v;
    if (at == nullptr || !numbers(file, *at, 6, &v)) return SE3::Identity();
    for (const char* key : {"frame", "relative_to"})
      if (const char* frame = at->Attribute(key); frame != nullptr && *frame != '\0')
        warn(file, *at, std::string("pose in frame '") + frame + "' is taken as the parent's");
    return from_xyz_rpy(v[0], v[1], v[2], v[3], v[4], v[5]);
  }
  std::array<float, 3> colour(const std::filesystem::path& file, const XMLElement* at,
                              std::array<float, 3> otherwise) {
    std::vector<double> rgb;
    if (at == nullptr || !numbers(file, *at, 3, &rgb)) return otherwise;
    return {static_cast<float>(rgb[2]), static_cast<float>(rgb[1]), static_cast<float>(rgb[0])};
  }
  void read_sky(const XMLElement* scene) {
    if (scene == nullptr) return;
    const auto sky = colour(file_, scene->FirstChildElement("background"), {0.7F, 0.7F, 0.7F});
    for (int k = 0; k < 3; ++k)
      world_.lighting.background_bgr[k] = 255.0F * sky[static_cast<std::size_t>(k)];
  }

  // "model://NAME/rest", "file://..." or relative to `file`; empty when it isn't there.
  std::filesystem::path find(const std::filesystem::path& file, std::string uri) const {
    const std::string model = "model://";
    if (uri.rfind(model, 0) == 0) {
      for (const auto& folder : folders_)
        if (std::filesystem::exists(folder / uri.substr(model.size())))
          return folder / uri.substr(model.size());
      return {};
    }
    if (uri.rfind("file://", 0) == 0) uri = uri.substr(7);
    const auto path = file.parent_path() / uri;
    return std::filesystem::exists(path) ? path : std::filesystem::path();
  }

  // Models, includes and lights below a world or a model.
  void things(const XMLElement& parent, const std::filesystem::path& file,
              const SE3& T_world_parent, const std::string& name, int depth) {
    for (const XMLElement* e = parent.FirstChildElement(); e != nullptr;
         e = e->NextSiblingElement()) {
      const std::string kind = e->Name();
      if (kind == "model")
        model(*e, file, T_world_parent * pose(file, *e), name_of(*e, name), depth);
      if (kind == "include") include(*e, file, T_world_parent, name, depth);
      if (kind == "light") light(*e, file, T_world_parent);
    }
  }
  static std::string name_of(const XMLElement& model, const std::string& otherwise) {
    const char* name = model.Attribute("name");
    return !otherwise.empty() || name == nullptr ? otherwise : name;
  }
  void light(const XMLElement& e, const std::filesystem::path& file, const SE3& T_world_parent) {
    const char* kind = e.Attribute("type");
    if (kind == nullptr || std::string(kind) != "point") {
      warn(file, e, "only point lights are rendered");
      return;
    }
    const auto diffuse = colour(file, e.FirstChildElement("diffuse"), {0.5F, 0.5F, 0.5F});
    world_.lighting.lamps_m.emplace_back((T_world_parent * pose(file, e)).translation());
    world_.lighting.lamp_scale.push_back(static_cast<double>(diffuse[1]) / 0.5);
  }
  void include(const XMLElement& e, const std::filesystem::path& file, const SE3& T_world_parent,
               const std::string& name, int depth) {
    const std::string uri = text_of(e.FirstChildElement("uri"));
    auto sdf = find(file, uri);
    if (!sdf.empty() && std::filesystem::is_directory(sdf)) sdf /= "model.sdf";
    if (sdf.empty() || !std::filesystem::is_regular_file(sdf)) {
      warn(file, e,
           "model '" + uri +
               "' is not there and left out; GAZEBO_MODEL_PATH may name "
               "its folder");
      return;
    }
    if (depth > kDeepest) {
      warn(file, e, "models within models more than " + std::to_string(kDeepest) + " deep");
      return;
    }
    tinyxml2::XMLDocument document;
    load(sdf, &document);
    const XMLElement* root = document.FirstChildElement("sdf");
    const XMLElement* inner = root == nullptr ? nullptr : root->FirstChildElement("model");
    if (inner == nullptr) {
      warn(file, e, sdf.string() + " holds no <model>");
      return;
    }
    // An include's own pose and name replace the model's.
    const SE3 T_parent_model =
        e.FirstChildElement("pose") != nullptr ? pose(file, e) : pose(sdf, *inner);
    std::string called = name;
    if (called.empty()) called = text_of(e.FirstChildElement("name"));
    model(*inner, sdf, T_world_parent * T_parent_model, name_of(*inner, called), depth + 1);
  }
  void model(const XMLElement& e, const std::filesystem::path& file, const SE3& T_world_model,
             const std::string& name, int depth) {
    things(e, file, T_world_model, name, depth);
    for (const XMLElement* link = e.FirstChildElement("link"); link != nullptr;
         link = link->NextSiblingElement("link"))
      for (const XMLElement* v = link->FirstChildElement("visual"); v != nullptr;
           v = v->NextSiblingElement("visual"))
        visual(*v, file, T_world_model * pose(file, *link) * pose(file, *v), name);
  }
  void visual(const XMLElement& e, const std::filesystem::path& file, const SE3& T_world_visual,
              const std::string& name) {
    const XMLElement* geometry = e.FirstChildElement("geometry");
    const XMLElement* shape = geometry == nullptr ? nullptr : geometry->FirstChildElement();
    if (shape == nullptr) return warn(file, e, "the visual has no geometry");
    const std::string kind = shape->Name();
    std::vector<Mesh> meshes;
    Eigen::Vector3d scale = Eigen::Vector3d::Ones();
    std::vector<double> v;
    if (kind == "mesh") {
      const std::string uri = text_of(shape->FirstChildElement("uri"));
      const auto path = find(file, uri);
      if (path.empty()) return warn(file, *shape, "'" + uri + "' is not there and left out");
      if (const auto* s = shape->FirstChildElement("scale"); s && numbers(file, *s, 3, &v))
        scale = Eigen::Vector3d(v[0], v[1], v[2]);
      meshes = files_.load(path);
    } else {
      Mesh mesh = shape_mesh(file, *shape, kind);
      if (mesh.triangles.empty()) return;
      const XMLElement* material = e.FirstChildElement("material");
      if (material != nullptr)
        mesh.bgr = colour(file, material->FirstChildElement("diffuse"), mesh.bgr);
      meshes.push_back(std::move(mesh));
    }
    if (!(scale.cwiseAbs().minCoeff() > 0.0)) return warn(file, e, "the scale is 0");
    for (Mesh& mesh : meshes) {
      Mesh thing = placed(std::move(mesh), T_world_visual, scale);
      thing.name = name;
      thing.obstacle = class_of_model(name);
      world_.meshes.push_back(std::move(thing));
    }
  }
  Mesh shape_mesh(const std::filesystem::path& file, const XMLElement& shape,
                  const std::string& kind) {
    const auto value = [&](const char* key, double otherwise) {
      const XMLElement* e = shape.FirstChildElement(key);
      std::vector<double> v;
      return e != nullptr && numbers(file, *e, 1, &v) && v[0] > 0.0 ? v[0] : otherwise;
    };
    std::vector<double> v;
    const XMLElement* size = shape.FirstChildElement("size");
    if (kind == "box" && size != nullptr && numbers(file, *size, 3, &v))
      return box_mesh({v[0], v[1], v[2]});
    if (kind == "plane") {
      if (size == nullptr || !numbers(file, *size, 2, &v)) v = {kLargestM, kLargestM};
      return plane_mesh(std::min(v[0], kLargestM), std::min(v[1], kLargestM));
    }
    if (kind == "cylinder") return cylinder_mesh(value("radius", 0.5), value("length", 1.0));
    if (kind == "sphere") return sphere_mesh(value("radius", 0.5));
    warn(file, shape, "a visual of kind '" + kind + "' is left out");
    return {};
  }

  std::filesystem::path file_;
  std::vector<std::filesystem::path> folders_;
  MeshFiles files_;
  World world_;
};

}  // namespace

World load_gazebo_world(const std::filesystem::path& path) { return Reader(path).read(); }

}  // namespace fusion_slam
