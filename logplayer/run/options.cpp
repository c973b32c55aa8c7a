#include "logplayer/run/options.hpp"

#include <CLI/CLI.hpp>

namespace fusion_slam {

const std::vector<std::string>& service_names() {
  static const std::vector<std::string> kNames{"visual_odometry", "lidar_mapper", "loop_detector",
                                               "pose_graph",      "dense_mapper", "fuser"};
  return kNames;
}

std::vector<std::string> service_names(const RunOptions& options) {
  if (!options.map.empty() && options.map_use == MapUse::kLocalize)
    return {"visual_odometry", "lidar_mapper", "localizer"};
  return service_names();
}

namespace {

// One word for the pace, one for the map: both are called --mode because people ask for "localize
// mode" as for "throughput mode".
void take_modes(const std::vector<std::string>& words, RunOptions* options) {
  for (const std::string& word : words) {
    if (word == "lockstep" || word == "throughput") {
      options->mode = word == "lockstep" ? Mode::kLockstep : Mode::kThroughput;
      continue;
    }
    if (options->map.empty())
      throw CLI::ValidationError("--mode " + word, "needs --map DIR: the saved map");
    options->map_use = word == "continue" ? MapUse::kContinue : MapUse::kLocalize;
  }
}

}  // namespace

std::optional<RunOptions> parse_run_options(int argc, char** argv, int* exit_code) {
  RunOptions options;
  options.programs = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  CLI::App app{"run: replays a log through all services and leaves a trajectory and maps"};
  app.add_option("LOG", options.log, "an LCM log (`fusion-slam import` makes one)")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("--out", options.out, "folder for the results, made when missing")->required();
  std::vector<std::string> words;
  app.add_option("--mode", words,
                 "the pace, lockstep: two runs give identical bytes (default), or throughput: "
                 "faster, not identical; with --map: localize (default) or continue. May be "
                 "repeated")
      ->check(CLI::IsMember({"lockstep", "throughput", "localize", "continue"}));
  app.add_option("--map", options.map,
                 "a saved map (`fusion-slam map save`) to localise in, or to continue");
  app.add_option("--lcm-url", options.lcm_url,
                 "use this LCM network, where others can listen, instead of a private one");
  app.add_option("--max-events", options.most_events, "stop after this many sensor events")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--without", options.without,
                 "play the log as if the robot had no camera, lidar or odometry; several: a,b")
      ->delimiter(',')
      ->check(CLI::IsMember({"camera", "lidar", "odometry"}));
  app.add_option("--relations", options.relations,
                 "score the trajectory against these relations (Kuemmerle et al. 2009)")
      ->check(CLI::ExistingFile);
  app.add_option("--time-offset", options.relations_time_offset_s,
                 "seconds added to the trajectory's times to get the relations' times");
  app.add_flag("!--no-session", options.keep_session, "don't record session.lcmlog");
  try {
    app.parse(argc, argv);
    take_modes(words, &options);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error) == 0 ? 0 : 2;
    return std::nullopt;
  }
  return options;
}

}  // namespace fusion_slam
