#include "logplayer/run/run.hpp"

#include <chrono>
#include <fstream>
#include <iostream>
#include <thread>

#include "libs/bus/process.hpp"
#include "libs/bus/transport.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/process/private_network.hpp"
#include "logplayer/report/report.hpp"
#include "logplayer/run/crew.hpp"
#include "logplayer/run/interrupt.hpp"
#include "logplayer/run/listener.hpp"
#include "logplayer/run/metrics.hpp"
#include "logplayer/run/on_map.hpp"
#include "logplayer/run/playback.hpp"

namespace fusion_slam {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

constexpr int kStart_s = 30;

class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Outcome {
  PlaybackResult playback;
  SessionResult session;
  LocalizationSummary localization;  // of a run on a saved map
  std::map<std::string, status_t> peers;
  std::map<std::string, std::int64_t> counts;
  std::string problem;  // empty: all went well
  double wall_s = 0.0;
};

// Its file begins with the STATUS messages of the services: then it hears everything.
void wait_for_logger(const RunOptions& options) {
  const auto deadline = Clock::now() + std::chrono::seconds(5);
  std::error_code ignored;
  while (options.keep_session && Clock::now() < deadline && interrupts() == 0) {
    const auto size_bytes = std::filesystem::file_size(options.out / "session.lcmlog", ignored);
    if (!ignored && size_bytes > 0) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

// The listener is another process to the others: give it the time to hear what was said last.
bool wait_for_listener(const Listener& listener, const Conductor& conductor) {
  const auto deadline = Clock::now() + std::chrono::seconds(20);
  while (!listener.has_all(conductor.counts()) && Clock::now() < deadline && interrupts() < 2)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return listener.has_all(conductor.counts());
}

Outcome replay(const RunOptions& options, const std::string& url) {
  Outcome outcome;
  auto transport = std::make_shared<Transport>(url);
  BusOptions bus_options;
  bus_options.process = "replay";
  bus_options.mode = Mode::kThroughput;
  Bus bus(bus_options, transport);
  Listener listener(transport);
  Crew crew(options, url);
  ConductorOptions conductor_options;
  conductor_options.mode = options.mode;
  conductor_options.processes = service_names(options);
  conductor_options.inert = {"ODOMETRY", "GROUND_TRUTH"};
  conductor_options.behind = {"dense_mapper", "fuser"};
  int tolerated = 0;
  Conductor conductor(bus, conductor_options, [&] {
    crew.check();
    if (interrupts() > tolerated) throw Interrupted("interrupted");
  });
  const auto started = Clock::now();
  try {
    conductor.wait_for_processes(kStart_s);
    wait_for_logger(options);
    tolerated = 1;  // the first Ctrl-C ends the playback, the second ends the waiting
    Progress progress;
    play_log(
        options.log, options.most_events, options.without, conductor, progress,
        [&listener](const LogEvent& event) { listener.sensor_event(event); }, &outcome.playback);
    progress.finish();
    if (!outcome.playback.damage.empty()) outcome.problem = outcome.playback.damage;
    if (outcome.playback.interrupted) outcome.problem = "interrupted: the result is partial";
    conductor.command("finish", outcome.playback.last_utime_us);
    if (!wait_for_listener(listener, conductor) && outcome.problem.empty())
      outcome.problem =
          "some of the last messages did not reach the collector: the maps may lack tiles";
  } catch (const std::exception& error) {
    outcome.problem = error.what();
  }
  outcome.wall_s = std::chrono::duration<double>(Clock::now() - started).count();
  outcome.peers = conductor.peers();
  outcome.counts = conductor.counts();
  crew.stop();
  outcome.session = listener.write(options.out);
  outcome.localization = listener.localization();
  return outcome;
}

void write_metrics(const RunOptions& options, const Outcome& outcome) {
  const double duration_s =
      1e-6 * static_cast<double>(outcome.playback.last_utime_us - outcome.playback.first_utime_us);
  Json json = {{"log", options.log.string()},
               {"mode", to_string(options.mode)},
               {"complete", outcome.problem.empty()},
               {"coverage_percent", outcome.session.coverage_percent}};
  if (!outcome.problem.empty()) json["problem"] = outcome.problem;
  json.update(accuracy_metrics(options, outcome.playback));
  json["camera_frames"] = outcome.session.camera_frames;
  json["lidar_scans"] = outcome.session.lidar_scans;
  json["trajectory_poses"] = outcome.session.trajectory_poses;
  json["path_length_m"] = outcome.session.path_length_m;
  json["map_source"] = outcome.session.map_source;
  json["free_area_m2"] = outcome.session.free_area_m2;
  json["occupied_area_m2"] = outcome.session.occupied_area_m2;
  if (!options.map.empty())
    json["map"] =
        map_metrics(options, outcome.localization, outcome.playback.first_sensor_utime_us);
  json["duration_s"] = duration_s;
  json["wall_s"] = outcome.wall_s;
  json["real_time_factor"] = outcome.wall_s > 0.0 ? duration_s / outcome.wall_s : 0.0;
  json["repeated_events_skipped"] = outcome.playback.repeats_skipped;
  json["undecodable_events_skipped"] = outcome.playback.undecodable_skipped;
  json.update(channel_metrics(outcome.peers, outcome.counts));
  if (options.keep_session)
    json["session_missing_total"] =
        missing_in_session(options.out / "session.lcmlog", outcome.counts);
  json["processes"] = process_metrics(outcome.peers);
  const auto partial = options.out / "metrics.json.partial";
  {
    std::ofstream file(partial);
    file << json.dump(2) << "\n";
    if (!file) throw std::runtime_error("cannot write " + partial.string());
  }
  std::filesystem::rename(partial, options.out / "metrics.json");
}

// What an earlier run left would pass for this one's. Never what this one reads.
void remove_results(const RunOptions& options) {
  std::vector<std::filesystem::path> results;
  for (const char* name :
       {"trajectory.tum", "live.tum", "groundtruth.tum", "map.pgm", "map.yaml", "map.png",
        "lidar_map.pgm", "lidar_map.yaml", "visual_map.pgm", "visual_map.yaml", "octomap.bt",
        "cloud.ply", "metrics.json", "report.html", "session.lcmlog"})
    results.push_back(options.out / name);
  for (const auto& result : results)
    for (const auto& input : {options.log, options.relations})
      if (!input.empty() && std::filesystem::exists(result) &&
          std::filesystem::equivalent(result, input))
        throw std::runtime_error("the results would overwrite " + input.string() +
                                 ": give another folder than " + options.out.string() +
                                 " to --out");
  for (const auto& result : results) std::filesystem::remove(result);
}

// The results are there already: a page that can't be made is no reason to fail.
void write_page(const RunOptions& options) {
  try {
    write_report({options.out, {}, {}});
  } catch (const std::exception& error) {
    std::cerr << "run: no report.html: " << error.what() << "\n";
  }
}

void tell(const RunOptions& options, const Outcome& outcome) {
  std::ifstream file(options.out / "metrics.json");
  const Json json = Json::parse(file);
  for (const char* key :
       {"coverage_percent", "ape_rmse_m", "rpe_rmse_m", "relations_used", "relations_total",
        "relations_translation_mean_m", "relations_rotation_mean_deg", "evaluation_problem",
        "duration_s", "wall_s", "real_time_factor", "dropped_total", "lost_total",
        "session_missing_total", "map"})
    if (json.contains(key)) std::cout << "  " << key << ": " << json[key] << "\n";
  if (outcome.playback.undecodable_skipped > 0)
    std::cout << "  " << outcome.playback.undecodable_skipped
              << " events of the log could not be decoded: `fusion-slam verify` says which\n";
  std::cout << "  files in " << options.out.string() << ":";
  for (const std::string& name : outcome.session.files) std::cout << " " << name;
  std::cout << " metrics.json report.html\n";
  for (const auto& missing : outcome.session.missing)
    std::cout << "  no " << missing.name << ": " << missing.reason << "\n";
}

}  // namespace

int run_log(const RunOptions& options) {
  watch_interrupts();
  const LogReader is_a_log(options.log);  // throws, before anything is started, when it is not
  check_map(options);
  std::filesystem::create_directories(options.out);
  remove_results(options);
  PrivateNetwork network{options.lcm_url, "the network " + options.lcm_url};
  if (options.lcm_url.empty()) network = enter_private_network();
  std::cerr << "run: " << options.log.string() << " in " << to_string(options.mode) << " mode, on "
            << network.description << "\n";
  Outcome outcome = replay(options, network.url);
  if (!options.map.empty() && options.map_use == MapUse::kContinue && outcome.problem.empty())
    outcome.problem = continue_map(options);
  write_metrics(options, outcome);
  write_page(options);
  tell(options, outcome);
  if (outcome.problem.empty()) return 0;
  std::cerr << "run: " << outcome.problem << "\n";
  return interrupts() > 0 ? 130 : 1;
}

}  // namespace fusion_slam
