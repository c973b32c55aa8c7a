// Localisation in a saved map from an unknown start: sessions of other drives through the same
// world (what `run` recorded) are begun at seeded moments; how long until the robot is found, and
// where? Prints a line a start and the sum.
//   localization_bench MAP MAP_TRUTH.tum SESSION.lcmlog ... [--starts 50] [--no-camera]
//   [--no-lidar]
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <random>

#include <CLI/CLI.hpp>

#include "bot_core/pose_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "libs/evaluation/alignment.hpp"
#include "libs/evaluation/association.hpp"
#include "libs/evaluation/tum_file.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/localization/localizer.hpp"
#include "libs/map_directory/decode.hpp"
#include "libs/messages/convert.hpp"
#include "libs/place_messages/place_messages.hpp"
#include "services/localizer/load_localization_map.hpp"

namespace fusion_slam {
namespace {

struct Options {
  std::string map, map_truth;
  std::vector<std::string> sessions;
  int starts = 50;
  unsigned seed = 1;
  double window_s = 5.0;
  double correct_m = 0.3;
  double correct_deg = 5.0;
  bool no_camera = false, no_lidar = false;
};

struct Session {
  std::string name;
  std::vector<LogEvent> events;  // by utime
  std::vector<std::int64_t> utimes_us;
  std::map<std::int64_t, SE3> T_world_base;
};

std::int64_t utime_of(const LogEvent& event) {
  std::int64_t utime = 0;  // int64 big-endian after the fingerprint
  for (std::size_t i = 8; i < 16; ++i)
    utime = static_cast<std::int64_t>(static_cast<std::uint64_t>(utime) << 8 | event.data[i]);
  return utime;
}

Session load(const std::string& file, const Options& options) {
  Session session;
  session.name = std::filesystem::path(file).parent_path().filename().string();
  LogReader reader(file);
  LogEvent event;
  while (reader.next(&event)) {
    if (event.channel == "GROUND_TRUTH") {
      if (const auto m = decode<bot_core::pose_t>(event))
        if (const auto T = from_message(*m)) session.T_world_base[m->utime] = *T;
    } else if ((event.channel == "KEYFRAME" && !options.no_camera) ||
               ((event.channel == "LIDAR_NODE" || event.channel == "LIDAR_POSE") &&
                !options.no_lidar)) {
      session.events.push_back(event);
    }
  }
  std::stable_sort(session.events.begin(), session.events.end(),
                   [](const LogEvent& a, const LogEvent& b) { return utime_of(a) < utime_of(b); });
  return session;
}

void feed(const LogEvent& event, Localizer* localizer) {
  std::string why;
  if (event.channel == "LIDAR_POSE") {
    const auto m = decode<pose_estimate_t>(event);
    if (!m) return;
    if (m->state == pose_estimate_t::OK || m->state == pose_estimate_t::WEAK)
      localizer->add_lidar_pose(m->utime, *from_message(m->T_frame_base));
    else
      localizer->lidar_lost();
  } else if (event.channel == "LIDAR_NODE") {
    const auto m = decode<lidar_node_t>(event);
    if (!m) return;
    localizer->add_scan({m->id, m->utime, *from_message(m->T_odom_base), m->previous_id == 0,
                         points_from(*m, &why).value_or(Points{})});
  } else {
    const auto m = decode<keyframe_t>(event);
    if (!m) return;
    localizer->add_view({m->id, m->utime, *from_message(m->T_odom_base), m->previous_id == 0,
                         features_from(*m, &why).value_or(FeatureSet{})});
  }
}

std::optional<SE3> truth_at(const Session& session, std::int64_t utime_us) {
  const auto after = session.T_world_base.lower_bound(utime_us);
  if (after == session.T_world_base.end() || after == session.T_world_base.begin())
    return std::nullopt;
  const auto before = std::prev(after);
  return interpolate(before->second, after->second,
                     static_cast<double>(utime_us - before->first) /
                         static_cast<double>(after->first - before->first));
}

// Where the world of the truth lies in the map: the map's own trajectory against its truth.
SE3 T_map_world(const Options& options) {
  const Trajectory map = read_tum(std::filesystem::path(options.map) / "trajectory.tum").trajectory;
  const auto matched = match_poses(read_tum(options.map_truth).trajectory, map, 0.02);
  if (!matched) throw std::runtime_error(matched.problem);
  const auto fit = find_alignment(*matched, Alignment::kSe3);
  if (!fit) throw std::runtime_error("the map's truth does not fit its trajectory: " + fit.problem);
  return fit->T_to_from.inverse();  // the alignment takes the estimate to the truth
}

int bench(const Options& options) {
  const MapReader reader(options.map);
  MapState state = read_state(reader);
  if (options.no_lidar) state.tiles.erase("GRID_LIDAR");
  if (options.no_camera) state.camera.reset();
  const LocalizationMap map = load_localization_map(reader, state);
  const SE3 T_map_truth = T_map_world(options);
  std::vector<Session> sessions;
  for (const std::string& file : options.sessions) sessions.push_back(load(file, options));

  std::mt19937 rng(options.seed);
  int correct = 0, wrong = 0;
  double sum_m = 0.0, worst_m = 0.0, sum_s = 0.0, worst_ms = 0.0;
  for (int n = 0; n < options.starts; ++n) {
    const Session& session = sessions[static_cast<std::size_t>(n) % sessions.size()];
    const std::int64_t first = utime_of(session.events.front());
    const std::int64_t last = utime_of(session.events.back());
    const auto window_us = static_cast<std::int64_t>(options.window_s * 1e6);
    const double share = (rng() >> 8) / static_cast<double>(1 << 24);
    const std::int64_t start =
        first + static_cast<std::int64_t>(share * static_cast<double>(last - first - window_us));
    Localizer localizer(map);
    localizer.set_sensors(!options.no_lidar, !options.no_camera);
    for (const LogEvent& event : session.events) {
      const std::int64_t utime = utime_of(event);
      if (utime < start) continue;
      if (utime > start + window_us) break;
      const auto before = std::chrono::steady_clock::now();
      feed(event, &localizer);
      worst_ms = std::max(worst_ms, std::chrono::duration<double, std::milli>(
                                        std::chrono::steady_clock::now() - before)
                                        .count());
      if (localizer.state() == LocalizationState::kLocalized) break;
    }
    std::printf("%2d %-6s %6.1f s: ", n + 1, session.name.c_str(),
                1e-6 * static_cast<double>(start - first));
    const bool found = localizer.state() == LocalizationState::kLocalized;
    const auto T_world_base =
        found ? truth_at(session, localizer.here()->utime_us) : std::optional<SE3>();
    if (!T_world_base) {
      std::printf("not found: %s\n", localizer.reason().c_str());
      continue;
    }
    const double after_s = 1e-6 * static_cast<double>(localizer.here()->utime_us - start);
    const Vector6d error = local(T_map_truth * *T_world_base, localizer.here()->T_map_base);
    const double error_m = error.head<3>().norm(), error_deg = error.tail<3>().norm() * 180 / M_PI;
    const bool good = error_m <= options.correct_m && error_deg <= options.correct_deg;
    good ? ++correct : ++wrong;
    if (good) sum_m += error_m, worst_m = std::max(worst_m, error_m), sum_s += after_s;
    std::printf("%s after %.2f s, %.3f m and %.2f deg off; %s\n", good ? "found" : "WRONG", after_s,
                error_m, error_deg, localizer.reason().c_str());
  }
  std::printf(
      "%d of %d found within %.1f s (mean %.2f s), %d wrong; error of those found: mean %.3f m, "
      "worst %.3f m; slowest message %.0f ms\n",
      correct, options.starts, options.window_s, correct > 0 ? sum_s / correct : 0.0, wrong,
      correct > 0 ? sum_m / correct : 0.0, worst_m, worst_ms);
  return wrong == 0 ? 0 : 1;
}

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  fusion_slam::Options options;
  CLI::App app{"Localisation in a saved map from seeded unknown starts"};
  app.add_option("MAP", options.map, "map directory")->required();
  app.add_option("MAP_TRUTH", options.map_truth, "groundtruth.tum of the run it was made of")
      ->required();
  app.add_option("SESSIONS", options.sessions, "session.lcmlog of other drives")->required();
  app.add_option("--starts", options.starts);
  app.add_option("--seed", options.seed);
  app.add_option("--window", options.window_s, "seconds of driving");
  app.add_flag("--no-camera", options.no_camera);
  app.add_flag("--no-lidar", options.no_lidar);
  CLI11_PARSE(app, argc, argv);
  try {
    return fusion_slam::bench(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "localization_bench: %s\n", error.what());
    return 1;
  }
}
