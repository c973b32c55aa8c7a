// report.html of an evaluation: the table of the terminal, the way coloured by its error, the error
// over time, and what lies beside the estimate when that is in a folder of `run` (map, processes,
// loops, settings). One self-contained file, like `run`'s.
#pragma once

#include <filesystem>
#include <string>

#include "libs/evaluation/trajectory_error.hpp"
#include "libs/evaluation/tum_file.hpp"
#include "logplayer/eval/options.hpp"

namespace fusion_slam {

// `table`: what eval prints. Throws std::runtime_error when the file can't be written.
void write_error_report(const EvalOptions& options, const TumFile& reference,
                        const TumFile& estimate, const TrajectoryError& result,
                        const std::string& table);

// For evaluations whose result is a table and perhaps a picture (PNG; empty: none).
void write_table_report(const std::filesystem::path& file, const std::string& title,
                        const std::string& table, const std::string& png);

}  // namespace fusion_slam
