// simulate: a short recording of a simulated robot, with exact ground truth.
#include <exception>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>

#include "drivers/simulator/recording.hpp"

int main(int argc, char** argv) {
  CLI::App app("Writes the LCM log of a simulated robot's drive, with exact ground truth",
               "simulate");
  std::string world_file, out;
  fusion_slam::SimulationOptions options;
  bool no_noise = false;
  app.add_option("WORLD", world_file, "world file, such as config/worlds/office.yaml")->required();
  app.add_option("--out", out, "the LCM log to write")->required();
  app.add_option("--seed", options.seed, "equal seeds give equal bytes")->capture_default_str();
  app.add_option("--seconds", options.seconds, "how long to drive")
      ->check(CLI::Range(0.5, 36000.0))
      ->capture_default_str();
  app.add_option("--camera-hz", options.camera_hz, "camera frames a second")
      ->check(CLI::Range(0.5, 120.0))
      ->capture_default_str();
  app.add_option("--threads", options.threads, "frames rendered at the same time")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_flag("--no-noise", no_noise, "ideal sensors and wheels");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    options.noise = !no_noise;
    const fusion_slam::World world = fusion_slam::load_world(world_file);
    const auto progress = [](std::int64_t done, std::int64_t of) {
      if (done % 50 == 0 || done == of)
        std::cerr << "\rrendered " << done << " of " << of << " frames" << std::flush;
    };
    const auto summary = fusion_slam::write_recording(world, options, out, progress);
    std::cerr << "\n";
    std::cout << out << ": " << summary.n_events << " messages, " << summary.n_frames << " frames, "
              << summary.size_bytes / 1'000'000 << " MB";
    if (summary.lap_s > 0.0) std::cout << "; back at the start after " << summary.lap_s << " s";
    std::cout << "\n";
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "simulate: " << error.what() << "\n";
    return 1;
  }
}
