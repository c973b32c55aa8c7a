// Models from files, read by Assimp: COLLADA (.dae) as Gazebo uses it, and whatever else Assimp
// knows (.obj, .stl, .ply, .glb).
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "drivers/simulator/mesh.hpp"

namespace fusion_slam {

// Reads each file once: models and pictures are used again and again in a world. One thread.
class MeshFiles {
 public:
  // The meshes of a file, one for each material, in the model's frame: metres, z up (a COLLADA
  // file's own unit and up axis are applied, and so are its nodes' transforms). Vertices that the
  // file gives no normals get smooth ones. A picture that is missing or unreadable becomes a plain
  // colour and a warning. Throws ConfigError naming the file when it can't be read or holds no
  // triangles.
  const std::vector<Mesh>& load(const std::filesystem::path& path);
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  std::shared_ptr<const MipMap> picture(const std::filesystem::path& model, std::string name);

  std::map<std::string, std::vector<Mesh>> models_;
  std::map<std::string, std::shared_ptr<const MipMap>> pictures_;  // empty: could not be read
  std::vector<std::string> warnings_;
};

}  // namespace fusion_slam
