#include "logplayer/run/metrics.hpp"

#include <algorithm>

#include "libs/evaluation/relations.hpp"
#include "libs/evaluation/trajectory_error.hpp"
#include "libs/evaluation/tum_file.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/eventlog/summary.hpp"

namespace fusion_slam {
namespace {

using Json = nlohmann::ordered_json;

void add_statistics(Json& json, const std::string& prefix, const std::string& unit,
                    const Statistics& s) {
  json[prefix + "_rmse_" + unit] = s.rmse;
  json[prefix + "_mean_" + unit] = s.mean;
  json[prefix + "_median_" + unit] = s.median;
  json[prefix + "_std_" + unit] = s.std;
  json[prefix + "_max_" + unit] = s.max;
}

void add_pose_errors(Json& json, const Trajectory& reference, const Trajectory& estimate,
                     const TimeWindow& played) {
  EvaluationOptions options;
  options.window = played;
  options.alignment = Alignment::kSe3;
  const auto ape = evaluate_ape(reference, estimate, options);
  if (!ape) {
    json["evaluation_problem"] = ape.problem;
    return;
  }
  json["ape_alignment"] = "se3";
  add_statistics(json, "ape", "m", ape->statistics);
  json["ape_pairs"] = ape->samples.size();
  json["reference_coverage_percent"] = ape->coverage.percent;
  const auto rpe = evaluate_rpe(reference, estimate, options, RelativeOptions{});
  if (!rpe) return;
  json["rpe_delta"] = "1 frame";
  add_statistics(json, "rpe", "m", rpe->statistics);
}

}  // namespace

Json process_metrics(const std::map<std::string, status_t>& peers) {
  Json all = Json::object();
  for (const auto& [name, status] : peers) {
    Json& json = all[name];
    json["latency_ms"] = {{"median", status.latency_ms_median},
                          {"p95", status.latency_ms_p95},
                          {"p99", status.latency_ms_p99}};
    json["cpu_s"] = status.cpu_s;
    json["peak_rss_bytes"] = status.peak_rss_bytes;
    if (!status.last_error.empty()) json["last_error"] = status.last_error;
  }
  return all;
}

Json channel_metrics(const std::map<std::string, status_t>& peers,
                     const std::map<std::string, std::int64_t>& counts) {
  std::int64_t dropped = 0;
  std::int64_t lost = 0;
  std::int64_t late = 0;
  std::int64_t rejected = 0;
  for (const auto& [name, status] : peers)
    for (const auto& channel : status.channels) {
      dropped += channel.dropped;
      lost += channel.lost;
      late += channel.late;
      rejected += channel.rejected;
    }
  return {{"dropped_total", dropped},
          {"lost_total", lost},
          {"late_total", late},
          {"rejected_total", rejected},
          {"channels", counts}};
}

std::int64_t missing_in_session(const std::filesystem::path& session,
                                const std::map<std::string, std::int64_t>& counts) {
  try {
    LogReader reader(session);
    const LogSummary summary = summarise(reader);
    std::int64_t missing = 0;
    for (const auto& [channel, count] : counts) {
      const auto logged = summary.channels.find(channel);
      const std::int64_t n = logged == summary.channels.end() ? 0 : logged->second.n_messages;
      missing += std::max<std::int64_t>(0, count - n);
    }
    return missing;
  } catch (const std::exception&) {
    return -1;
  }
}

Json accuracy_metrics(const RunOptions& options, const PlaybackResult& playback) {
  Json json = Json::object();
  const auto trajectory_file = options.out / "trajectory.tum";
  const auto reference_file = options.out / "groundtruth.tum";
  if (!std::filesystem::exists(trajectory_file)) return json;
  try {
    const Trajectory estimate = read_tum(trajectory_file).trajectory;
    if (std::filesystem::exists(reference_file))
      add_pose_errors(json, read_tum(reference_file).trajectory, estimate,
                      {1e-6 * static_cast<double>(playback.first_sensor_utime_us),
                       1e-6 * static_cast<double>(playback.last_sensor_utime_us)});
    if (options.relations.empty()) return json;
    RelationsOptions relations;
    relations.time_offset_s = options.relations_time_offset_s;
    const auto error = evaluate_relations(read_relations(options.relations), estimate, relations);
    if (!error) {
      json["evaluation_problem"] = error.problem;
      return json;
    }
    json["relations_used"] = error->usable;
    json["relations_total"] = error->total;
    json["relations_translation_mean_m"] = error->translation_m.mean;
    json["relations_translation_std_m"] = error->translation_m.std;
    json["relations_rotation_mean_deg"] = error->rotation_deg.mean;
    json["relations_rotation_std_deg"] = error->rotation_deg.std;
  } catch (const std::exception& error) {
    json["evaluation_problem"] = error.what();
  }
  return json;
}

}  // namespace fusion_slam
