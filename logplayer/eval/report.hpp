// An evaluation as a table for people, as JSON for programs, and as the words of its plot.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "libs/evaluation/plot/error_plot.hpp"
#include "libs/evaluation/relations.hpp"
#include "libs/evaluation/trajectory_error.hpp"
#include "libs/evaluation/tum_file.hpp"
#include "logplayer/eval/options.hpp"

namespace fusion_slam {

std::string to_table(const EvalOptions& options, const TumFile& reference, const TumFile& estimate,
                     const TrajectoryError& result);
nlohmann::ordered_json to_json(const EvalOptions& options, const TumFile& reference,
                               const TumFile& estimate, const TrajectoryError& result);
ErrorPlotText to_plot_text(const EvalOptions& options, const TrajectoryError& result);

std::string to_table(const EvalOptions& options, const TumFile& estimate,
                     const RelationsError& result);
nlohmann::ordered_json to_json(const EvalOptions& options, const TumFile& estimate,
                               const RelationsError& result);

}  // namespace fusion_slam
