// simulate: a recording of a simulated robot, with exact ground truth.
#include <exception>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "drivers/simulator/arguments.hpp"
#include "drivers/simulator/recording.hpp"
#include "drivers/simulator/truth_files.hpp"
#include "libs/log_export/carmen_export.hpp"
#include "libs/log_export/tum_export.hpp"

int main(int argc, char** argv) {
  CLI::App app("Writes the LCM log of a simulated robot's drive, with exact ground truth",
               "simulate");
  fusion_slam::SimulationArguments arguments;
  std::string out, truth, tum, carmen;
  fusion_slam::add_simulation_arguments(app, &arguments);
  app.add_option("--out", out, "the LCM log to write")->required();
  app.add_option(
      "--truth", truth,
      "directory for the true map: map.yaml, classes.pgm (for `eval map`), surfaces.ply");
  app.add_option("--export-tum", tum, "also a TUM RGB-D directory of the run (see `export tum`)");
  app.add_option("--export-carmen", carmen, "also a CARMEN log of the run (see `export carmen`)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    const auto input = fusion_slam::read_simulation(arguments);
    for (const std::string& warning : input.world.warnings)
      std::cerr << "simulate: " << warning << "\n";
    const fusion_slam::Simulation simulation(input.world, input.route, input.options);
    if (!truth.empty())
      fusion_slam::write_truth(input.world, simulation.way_points_m(), simulation.robot(),
                               simulation.robot().map_resolution_m, truth);
    const bool terminal = isatty(2) != 0;
    const auto progress = [terminal](std::int64_t done, std::int64_t of) {
      if (done == of || done % (terminal ? 15 : 300) == 0)
        std::cerr << (terminal ? "\r" : "") << "rendered " << done << " of " << of << " frames"
                  << (terminal && done != of ? "" : "\n") << std::flush;
    };
    const auto summary =
        fusion_slam::write_recording(simulation, input.options.threads, out, progress);
    std::cout << out << ": " << summary.seconds << " s, " << summary.n_events << " messages, "
              << summary.n_frames << " frames, " << summary.size_bytes / 1'000'000 << " MB";
    if (summary.lap_s > 0.0) std::cout << "; back at the start after " << summary.lap_s << " s";
    std::cout << "\n";
    if (!tum.empty()) fusion_slam::export_tum(out, tum, {});
    if (!carmen.empty()) fusion_slam::export_carmen(out, carmen, {});
    return 0;
  } catch (const std::invalid_argument& error) {
    std::cerr << "simulate: " << error.what() << "\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "simulate: " << error.what() << "\n";
    return 1;
  }
}
