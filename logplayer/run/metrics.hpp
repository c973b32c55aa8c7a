// metrics.json: what a run cost and, where there is a reference, how good it was.
#pragma once

#include <nlohmann/json.hpp>

#include "logplayer/replay/conductor.hpp"
#include "logplayer/run/options.hpp"
#include "logplayer/run/playback.hpp"

namespace fusion_slam {

// Latency, CPU and memory of each process; messages, drops and losses by channel and in total.
nlohmann::ordered_json process_metrics(const std::map<std::string, status_t>& peers);
nlohmann::ordered_json channel_metrics(const std::map<std::string, status_t>& peers,
                                       const std::map<std::string, std::int64_t>& counts);

// Messages that were on the network (counts, by channel) but are not in session.lcmlog: lcm-logger
// listens like anybody and can't ask for what it lost. -1: the file can't be read.
std::int64_t missing_in_session(const std::filesystem::path& session,
                                const std::map<std::string, std::int64_t>& counts);

// ape_rmse_m, rpe_rmse_m and their kin from OUT/trajectory.tum against OUT/groundtruth.tum,
// relations_* against the relations file; only the fields for which there is a reference. What
// can't be computed is said in "evaluation_problem".
nlohmann::ordered_json accuracy_metrics(const RunOptions& options, const PlaybackResult& playback);

}  // namespace fusion_slam
