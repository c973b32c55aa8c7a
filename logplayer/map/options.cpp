#include <functional>
#include <iostream>
#include <map>

#include <CLI/CLI.hpp>

#include "libs/map_directory/map_saver.hpp"
#include "logplayer/map/commands.hpp"

namespace fusion_slam {

std::optional<MapOptions> parse_map_options(int argc, char** argv, int* exit_code) {
  MapOptions options;
  CLI::App app("Maps on disk: a directory with the journal, the composed maps and checksums",
               "map");
  app.require_subcommand(1);
  auto* save = app.add_subcommand("save", "make a map directory of a finished session");
  save->add_option("SESSION", options.session,
                   "what `fusion-slam run` or `record` left: its folder or the session.lcmlog")
      ->required();
  save->add_option("DIR", options.map, "the map; an older one there is replaced in one step")
      ->required();
  save->add_flag("!--no-images", options.images,
                 "leave the keyframes' images out: smaller, but no dense map after a merge");
  auto* load = app.add_subcommand("load", "check a map whole and publish it until Ctrl-C");
  load->add_option("DIR", options.map, "the map")->required();
  load->add_flag("--check", options.check_only, "only check it");
  load->add_option("--lcm-url", options.lcm_url,
                   "LCM network (default: LCM_DEFAULT_URL, else LCM's own)");
  auto* info = app.add_subcommand("info", "what is in a map");
  info->add_option("DIR", options.map, "the map")->required();
  auto* exporter = app.add_subcommand("export", "a map in a format that others read");
  exporter->add_option("DIR", options.map, "the map")->required();
  exporter
      ->add_option("--format", options.format,
                   "pgm (with a .yaml for ROS), png, bt, ot, ply, pcd, tum")
      ->required()
      ->check(CLI::IsMember({"pgm", "png", "bt", "ot", "ply", "pcd", "tum"}));
  exporter->add_option("--grid", options.grid, "of pgm and png: best, fused, lidar, visual")
      ->check(CLI::IsMember({"best", "fused", "lidar", "visual"}))
      ->capture_default_str();
  exporter->add_option("OUT", options.out, "the file to write")->required();
  auto* merge =
      app.add_subcommand("merge", "join two maps of one place, or say that no overlap is proven");
  merge->add_option("A", options.map, "the first map: the result is in its frame")->required();
  merge->add_option("B", options.other, "the second map")->required();
  merge->add_option("OUT", options.out, "the joined map; may be A or B")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error) == 0 ? 0 : 2;
    return std::nullopt;
  }
  options.verb = app.get_subcommands().front()->get_name();
  return options;
}

int save_map(const MapOptions& options) {
  MapSaveOptions how;
  how.images = options.images;
  const MapSummary summary = save_session(options.session, options.map, how);
  std::cout << options.map.string() << ": " << describe(summary);
  for (const auto& [channel, lost] : summary.lost)
    std::cerr << "map: warning: " << lost << " " << channel << " of this session "
              << (lost == 1 ? "was" : "were")
              << " not recorded; to localise or merge, those places are missing from the map. Run "
                 "the log again on a machine with less load, or in lockstep\n";
  return 0;
}

int run_map_command(const MapOptions& options) {
  static const std::map<std::string, std::function<int(const MapOptions&)>> kCommands{
      {"save", save_map},
      {"load", load_map},
      {"info", show_map},
      {"export", export_map},
      {"merge", merge_two_maps}};
  return kCommands.at(options.verb)(options);
}

}  // namespace fusion_slam
