// link: fs_simulator
// Any text as a world: refused with a ConfigError, or boxes that have a size and a finite place.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "drivers/simulator/world.hpp"
#include "libs/config/yaml_map.hpp"

namespace {

void require(bool ok) {
  if (!ok) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto world = fusion_slam::world_from_text(
        std::string(reinterpret_cast<const char*>(data), size), "fuzz.yaml");
    require(world.route_m.size() >= 2 && world.limits.max_speed_m_s > 0.0);
    for (const auto& box : world.boxes) {
      require(box.T_world_box.matrix().allFinite());
      require(box.half_m.allFinite() && box.half_m.minCoeff() > 0.0);
    }
    const fusion_slam::Scene scene(world.boxes);
    const Eigen::Vector3d eye(world.route_m[0].x(), world.route_m[0].y(), 0.3);
    for (const Eigen::Vector3d& way : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0.6, -0.8, -0.1)})
      if (const auto hit = scene.cast(eye, way)) require(scene.normal(*hit).allFinite());
  } catch (const fusion_slam::ConfigError&) {
  }
  return 0;
}
