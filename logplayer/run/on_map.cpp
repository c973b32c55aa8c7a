#include "logplayer/run/on_map.hpp"

#include <iostream>
#include <stdexcept>

#include "libs/map_directory/map_reader.hpp"
#include "libs/map_directory/map_saver.hpp"
#include "logplayer/map_merge/merge.hpp"

namespace fusion_slam {

void check_map(const RunOptions& options) {
  if (options.map.empty()) return;
  const MapReader whole(options.map);
  if (options.map_use == MapUse::kContinue && !options.keep_session)
    throw std::runtime_error("--mode continue joins the recorded session: leave --no-session out");
  if (std::filesystem::exists(options.out) &&
      (std::filesystem::equivalent(options.out, options.map) ||
       (std::filesystem::exists(options.out / "map") &&
        std::filesystem::equivalent(options.out / "map", options.map))))
    throw std::runtime_error("the results would be written into the map " + options.map.string() +
                             ": give another folder to --out");
}

nlohmann::ordered_json map_metrics(const RunOptions& options,
                                   const LocalizationSummary& localization,
                                   std::int64_t first_sensor_utime_us) {
  nlohmann::ordered_json json = {{"directory", options.map.string()}};
  if (options.map_use != MapUse::kLocalize) return json;
  json["state"] = localization.state;
  json["localized"] = localization.localized_utime_us != 0;
  if (localization.localized_utime_us != 0)
    json["localized_after_s"] =
        1e-6 * static_cast<double>(localization.localized_utime_us - first_sensor_utime_us);
  json["times_lost"] = localization.times_lost;
  return json;
}

std::string continue_map(const RunOptions& options) {
  const auto session = options.out / "session.map";
  std::string problem;
  try {
    save_session(options.out, session, {});
    const MergeReport report = merge_maps(options.map, session, options.out / "map");
    std::cout << "  joined to " << options.map.string() << " by " << report.cross_loops
              << " closures: " << (options.out / "map").string() << "\n";
  } catch (const std::exception& error) {
    problem =
        std::string("the session was mapped but not joined to the saved map: ") + error.what();
  }
  std::error_code ignored;
  std::filesystem::remove_all(session, ignored);
  return problem;
}

}  // namespace fusion_slam
