// link: fs_config
// Any text as a robot's or a sensor's description: taken, with every number in its range, or
// refused with a ConfigError.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "libs/config/robot_config.hpp"
#include "libs/config/sensors.hpp"
#include "tests/fuzz/temporary_folder.hpp"

namespace {

namespace fs = std::filesystem;

void require(bool ok) {
  if (!ok) std::abort();
}

void write_text(const fs::path& path, const std::string& text) {
  fusion_slam::write_file(path, text.data(), text.size());
}

fs::path make_folder() {
  const fs::path folder = fusion_slam::temporary_folder();
  fs::create_directories(folder / "robots");
  fs::create_directories(folder / "sensors");
  fs::create_directories(folder / "other");
  write_text(folder / "sensors/sick.yaml", "kind: lidar\n");
  write_text(folder / "sensors/kinect.yaml", "kind: camera\n");
  return folder;
}

template <class Load>
void try_load(Load load) {
  try {
    load();
  } catch (const fusion_slam::ConfigError& error) {
    require(*error.what() != '\0');
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fs::path folder = make_folder();
  const fs::path file = folder / "robots/fuzz.yaml";
  fusion_slam::write_file(file, data, size);
  try_load([&] {
    const auto config = fusion_slam::load_robot_config(file);
    require(config.robot.T_base_lidar.matrix().allFinite());
    require(config.robot.T_base_camera.matrix().allFinite());
    require(config.robot.map_resolution_m >= 0.005 && config.robot.map_resolution_m <= 1.0);
    require(config.robot.has_lidar || config.robot.has_camera);
  });
  try_load([&] {
    const auto model = fusion_slam::load_lidar_model(file);
    require(model.range_min_m < model.range_max_m && model.sigma_m > 0.0);
  });
  try_load([&] {
    const auto model = fusion_slam::load_camera_model(file);
    require(model.width_px >= 16 && model.height_px >= 16 && model.fx_px > 0.0);
    for (const double k : model.distortion) require(std::isfinite(k));
  });
  fs::rename(file, folder / "other/fuzz.yaml");
  try_load([&] { fusion_slam::sensor_names(folder / "other", "lidar"); });
  return 0;
}
