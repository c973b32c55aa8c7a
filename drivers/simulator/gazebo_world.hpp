// Gazebo's world files (SDF): which models stand where. Only what a camera and a LiDAR meet is
// read: the visuals of models and point lights; no physics, no plug-ins, no joints.
#pragma once

#include <filesystem>

#include "drivers/simulator/world.hpp"

namespace fusion_slam {

// Models are looked for in the folders that GAZEBO_MODEL_PATH names, and in `models` and the
// folder itself beside and above the world file. Visuals may be meshes, boxes, cylinders, spheres
// and planes (of 40 m at most). Everything placed gets its class from its model's name. The world
// has no route of its own: see route.hpp. What is not understood or missing (models, pictures) is
// left out and said in World::warnings. Throws ConfigError naming the file when it is no world.
World load_gazebo_world(const std::filesystem::path& path);

}  // namespace fusion_slam
