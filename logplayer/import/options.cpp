#include "logplayer/import/options.hpp"

#include <CLI/CLI.hpp>

namespace fusion_slam {

std::optional<ImportOptions> parse_options(int argc, char** argv, int* exit_code) {
  ImportOptions options;
  CLI::App app(
      "Turns a recording into a standard LCM log with CAMERA, CAMERA_MODEL, LIDAR, ROBOT_MODEL, "
      "ODOMETRY and GROUND_TRUTH, as far as the recording has them.",
      "import");
  app.add_option("FORMAT", options.format,
                 "tum: TUM RGB-D directory; 7scenes: 7-Scenes directory; carmen: CARMEN log (.log, "
                 ".clf, .gz); rplidar-lcm: LCM log of a MAEBot; hokuyo: Mines ParisTech text")
      ->required()
      ->check(CLI::IsMember({"tum", "7scenes", "carmen", "rplidar-lcm", "hokuyo"}));
  app.add_option("SRC", options.source, "the recording: a directory or a file")
      ->required()
      ->check(CLI::ExistingPath);
  app.add_option("OUT", options.output, "the log to write, OUT.lcm")->required();
  app.add_flag("--no-odometry", options.no_odometry, "leave wheel odometry out");
  app.add_option("--robot", options.robot_file,
                 "robot description (YAML) instead of the format's own in config/robots")
      ->check(CLI::ExistingFile);
  app.add_option("--max-frames", options.max_frames, "at most so many camera frames or scans")
      ->check(CLI::PositiveNumber);
  app.add_option("--start", options.start, "leave out so many frames or scans at the beginning")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--ground-truth", options.ground_truth,
                 "TUM trajectory (seconds tx ty tz qx qy qz qw) to publish as GROUND_TRUTH instead "
                 "of the recording's own")
      ->check(CLI::ExistingFile);
  app.add_flag("--corrected-as-ground-truth", options.corrected_as_ground_truth,
               "carmen: poses that a SLAM program has corrected become GROUND_TRUTH (they are left "
               "out otherwise)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error) == 0 ? 0 : 2;
    return std::nullopt;
  }
  return options;
}

}  // namespace fusion_slam
