// render_bench: frames and LiDAR sweeps a second and core, over a world's route.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <exception>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>

#include "drivers/simulator/camera_renderer.hpp"
#include "drivers/simulator/drive.hpp"
#include "drivers/simulator/route.hpp"
#include "drivers/simulator/world.hpp"

namespace {

using namespace fusion_slam;

// Processor time, because machines are shared.
double cpu_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Measures rendering on one core, in processor time", "render_bench");
  std::string world_file, route_file;
  int n = 100;
  app.add_option("WORLD", world_file, "world file")->required();
  app.add_option("--route", route_file, "route file, for worlds without a route");
  app.add_option("--frames", n, "evenly over the first lap")->check(CLI::Range(1, 100000));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    double from = cpu_s();
    World world = load_world(world_file);
    double seconds = 600.0;
    if (!route_file.empty()) {
      const Route route = load_route(route_file);
      world.route_m = route.way_points_m;
      world.limits = route.limits;
      seconds = route.seconds.value_or(seconds);
    }
    const Drive drive(world.route_m, world.limits, seconds);
    if (drive.lap_s() > 0.0) seconds = drive.lap_s();
    const double loaded = cpu_s() - from;
    from = cpu_s();
    const Scene scene(world.boxes, world.meshes);
    std::printf("%s: loaded in %.2f s, ray tree in %.2f s\n", world_file.c_str(), loaded,
                cpu_s() - from);
    CameraModel camera;
    camera.fx_px = camera.fy_px = 570.0;
    const CameraRenderer renderer(scene, world.lighting, camera);
    const CameraRenderer aliased(scene, world.lighting, camera, false);
    SE3 T_base_camera = from_xyz_rpy(0.1, 0.0, 0.35, 0.0, 0.0, 0.0);
    T_base_camera.linear() = optical_to_body();
    const auto pose = [&](int i) {
      return SE3(to_se3(drive.T_world_base(seconds * i / n)) * T_base_camera);
    };
    double sum = 0.0;
    const auto lap = [&](const CameraRenderer& with) {
      const double start = cpu_s();
      for (int i = 0; i < n; ++i)
        sum += static_cast<double>(with.render(pose(i)).depth_m(240, 320));
      return cpu_s() - start;
    };
    const double first = lap(renderer);
    const double again = lap(renderer);
    std::printf("painting what is seen: %.2f s\n", first - again);
    std::printf("camera 640x480: %.2f ms a frame, %.1f frames/s/core\n", 1e3 * again / n,
                n / again);
    lap(aliased);
    const double plain = lap(aliased);
    std::printf("  of which edges: %.2f ms\n", 1e3 * (again - plain) / n);
    from = cpu_s();
    constexpr int kBeams = 360;
    for (int i = 0; i < n; ++i) {
      const SE3 T = pose(i);
      for (int k = 0; k < kBeams; ++k) {
        const double angle = 2.0 * M_PI * k / kBeams;
        const auto hit = scene.cast(T.translation(), {std::cos(angle), std::sin(angle), 0.0});
        if (hit) sum += hit->t;
      }
    }
    const double lidar = cpu_s() - from;
    std::printf("LiDAR: %.3f ms a sweep of %d beams\n", 1e3 * lidar / n, kBeams);
    std::printf("30 Hz camera + 10 Hz LiDAR: %.0f %% of a core (checksum %.3f)\n",
                100.0 * (30.0 * again + 10.0 * lidar) / n, sum);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "render_bench: " << error.what() << "\n";
    return 1;
  }
}
