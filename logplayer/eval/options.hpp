// The command line of `eval`.
#pragma once

#include <filesystem>
#include <string>

#include "libs/evaluation/relations.hpp"
#include "libs/evaluation/trajectory_error.hpp"
#include "logplayer/eval/map_task.hpp"

namespace fusion_slam {

enum class EvalTask { kApe, kRpe, kRelations, kMap };

struct EvalOptions {
  EvalTask task = EvalTask::kApe;
  std::filesystem::path reference;  // trajectory, or relations
  std::filesystem::path estimate;
  EvaluationOptions evaluation;
  RelativeOptions relative;
  RelationsOptions relations;
  MapTaskOptions map;            // with its own files
  std::filesystem::path json;    // empty: none
  std::filesystem::path plot;    // empty: none
  std::filesystem::path report;  // empty: none
};

// Fills `options` and returns -1, or prints help (returns 0) or what is wrong with the usage
// (returns 2).
int parse_command_line(int argc, char** argv, EvalOptions& options);

}  // namespace fusion_slam
