#include "logplayer/import/import.hpp"

#include <algorithm>
#include <iomanip>
#include <limits>
#include <ostream>

#include "logplayer/import/log_output.hpp"
#include "logplayer/import/sources.hpp"

namespace fusion_slam {
namespace {

struct Format {
  const char* robot;  // of config/robots
  Timeline (*source)(const ImportOptions&, RobotConfig*);
  bool lidar;  // what the recording has; the robot description must have it too
};

const std::map<std::string, Format> kFormats = {
    {"tum", {"hand-held-kinect", tum_source, false}},
    {"7scenes", {"hand-held-kinect", seven_scenes_source, false}},
    {"carmen", {"carmen-sick", carmen_source, true}},
    {"rplidar-lcm", {"maebot", maebot_source, true}},
    {"hokuyo", {"mines-rover", hokuyo_source, true}},
};

RobotConfig load_robot(const ImportOptions& options, const Format& format) {
  const std::filesystem::path file =
      options.robot_file.empty()
          ? config_directory() / "robots" / (std::string(format.robot) + ".yaml")
          : options.robot_file;
  RobotConfig config = load_robot_config(file);
  if (format.lidar ? !config.robot.has_lidar : !config.robot.has_camera)
    throw ConfigError(
        file.string() + ": describes a robot without a " + (format.lidar ? "lidar" : "camera") +
        ", but the recording has one; add the key '" + (format.lidar ? "lidar" : "camera") + "'");
  return config;
}

void replace_ground_truth(const std::filesystem::path& file, Timeline* timeline) {
  const ReferenceTrajectory trajectory = read_tum_trajectory(file);
  auto& events = timeline->events;
  events.erase(std::remove_if(events.begin(), events.end(),
                              [](const auto& e) { return e.kind == EventKind::kGroundTruth; }),
               events.end());
  for (const ReferencePose& p : trajectory.poses)
    timeline->add_pose(EventKind::kGroundTruth, "GROUND_TRUTH", p.utime_us, p.T_world_reference);
  for (const auto& [reason, entry] : trajectory.skipped.reasons())
    timeline->notes.push_back(file.string() + ": " + std::to_string(entry.count) +
                              " lines skipped (" + reason + ", first at line " +
                              std::to_string(entry.first_place) + ")");
}

bool holds(const Timeline& timeline, EventKind kind) {
  return std::any_of(timeline.events.begin(), timeline.events.end(),
                     [kind](const auto& e) { return e.kind == kind; });
}

void show_progress(std::size_t done, std::size_t total, std::ostream* progress) {
  if (progress == nullptr || (done % 100 != 0 && done != total)) return;
  *progress << "\rimport: " << done << " of " << total << " events" << (done == total ? "\n" : "")
            << std::flush;
}

}  // namespace

ImportSummary run_import(const ImportOptions& options, std::ostream* progress) {
  const Format& format = kFormats.at(options.format);
  std::error_code ignored;
  if (std::filesystem::equivalent(options.source, options.output, ignored))
    throw DatasetError(options.output.string() + ": is the recording itself; give another OUT");
  RobotConfig config = load_robot(options, format);
  config.robot.has_lidar = format.lidar;
  config.robot.has_camera = !format.lidar;
  Timeline timeline = format.source(options, &config);
  if (!options.ground_truth.empty()) replace_ground_truth(options.ground_truth, &timeline);
  timeline.sort();
  timeline.keep_frames(options.start,
                       options.max_frames.value_or(std::numeric_limits<std::int64_t>::max()));
  if (timeline.events.empty())
    throw DatasetError(options.source.string() + ": no frame is left after --start " +
                       std::to_string(options.start) + "; give a smaller number");
  config.robot.has_odometry = holds(timeline, EventKind::kOdometry);

  LogWriter writer(options.output);
  LogOutput output(&writer, config);
  ImportSummary summary;
  summary.skipped = timeline.skipped;
  std::int64_t frames = 0;
  for (std::size_t i = 0; i < timeline.events.size(); ++i) {
    const TimelineEvent& event = timeline.events[i];
    const std::string why = event.write(output);
    if (!why.empty()) summary.skipped.add(static_cast<std::int64_t>(i), why);
    frames += why.empty() && event.kind >= EventKind::kLidar ? 1 : 0;
    show_progress(i + 1, timeline.events.size(), progress);
  }
  if (frames == 0) {
    const auto& [reason, entry] = *summary.skipped.reasons().begin();
    throw DatasetError(options.source.string() + ": not one frame could be read (" + reason +
                       "); unpack it again");
  }
  writer.close();
  summary.messages = output.counts();
  summary.size_bytes = writer.size_bytes();
  summary.largest_message_bytes = output.largest_message_bytes();
  summary.duration_s = 1e-6 * static_cast<double>(timeline.events.back().utime_us -
                                                  timeline.events.front().utime_us);
  summary.place_name = timeline.place_name;
  summary.notes = timeline.notes;
  return summary;
}

void print_summary(const ImportOptions& options, const ImportSummary& summary, std::ostream& out) {
  out << std::fixed << std::setprecision(1);
  out << options.output.string() << ": " << static_cast<double>(summary.size_bytes) / 1e6 << " MB, "
      << summary.duration_s << " s, largest message "
      << (summary.largest_message_bytes + 999) / 1000 << " KB\n";
  for (const auto& [channel, count] : summary.messages)
    out << "  " << std::left << std::setw(14) << channel << std::right << std::setw(8) << count
        << "\n";
  for (const auto& [reason, entry] : summary.skipped.reasons())
    out << "  skipped " << entry.count << ": " << reason << " (first: " << summary.place_name << " "
        << entry.first_place << ")\n";
  for (const std::string& note : summary.notes) out << "  note: " << note << "\n";
}

}  // namespace fusion_slam
