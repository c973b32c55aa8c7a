#include "logplayer/eval/options.hpp"

#include <map>
#include <vector>

#include <CLI/CLI.hpp>

namespace fusion_slam {
namespace {

// CLI11's own check names the greatest double when it complains.
const CLI::Validator kAboveZero(
    [](const std::string& text) {
      double value = 0.0;
      const bool good = CLI::detail::lexical_cast(text, value) && value > 0.0;
      return good ? std::string() : "must be a number above 0, not " + text;
    },
    "NUMBER > 0");
const CLI::Validator kNotNegative(
    [](const std::string& text) {
      double value = 0.0;
      const bool good = CLI::detail::lexical_cast(text, value) && value >= 0.0;
      return good ? std::string() : "must be a number, 0 or above, not " + text;
    },
    "NUMBER >= 0");

const char* const kReportHelp =
    "write a page for people: one file, with what `run` left beside the estimate";

template <typename Enum>
std::map<std::string, Enum> by_name(const std::vector<Enum>& values) {
  std::map<std::string, Enum> names;
  for (const Enum value : values) names.emplace(name_of(value), value);
  return names;
}

const auto kAlignments =
    by_name<Alignment>({Alignment::kNone, Alignment::kOrigin, Alignment::kSe3, Alignment::kSim3});
const auto kRelations = by_name<ErrorRelation>(
    {ErrorRelation::kTranslation, ErrorRelation::kRotation, ErrorRelation::kFull});
const auto kUnits =
    by_name<DeltaUnit>({DeltaUnit::kFrames, DeltaUnit::kMeters, DeltaUnit::kDegrees});

// An option that takes one of the names and nothing else.
template <typename Enum>
void add_choice(CLI::App& app, const std::string& name, Enum& target,
                const std::map<std::string, Enum>& choices, const std::string& help) {
  app.add_option_function<std::string>(
         name, [&target, &choices](const std::string& key) { target = choices.at(key); }, help)
      ->check(CLI::IsMember(choices))
      ->default_str(std::string(name_of(target)));
}

void add_trajectory_options(CLI::App& app, EvalOptions& options, std::vector<double>& window) {
  app.add_option("REF", options.reference, "reference trajectory, TUM format")->required();
  app.add_option("EST", options.estimate, "estimated trajectory, TUM format")->required();
  add_choice(app, "--align", options.evaluation.alignment, kAlignments,
             "move the estimate first: none, origin (first poses coincide), se3 (least squares), "
             "sim3 (with scale)");
  add_choice(app, "--relation", options.evaluation.relation, kRelations,
             "what is compared: translation (m), rotation (deg), full (|E - I|)");
  app.add_option("--max-diff", options.evaluation.max_diff_s,
                 "poses belong together when their times differ by at most this (s)")
      ->check(kNotNegative)
      ->capture_default_str();
  app.add_option("--window", window,
                 "times (s) between which coverage is asked for; default: all of the reference")
      ->expected(2)
      ->type_name("FROM TO");
  app.add_option("--plot", options.plot, "draw trajectories and error over time into this PNG")
      ->type_name("FILE.png");
}

void add_relative_options(CLI::App& app, EvalOptions& options) {
  app.add_option("--delta", options.relative.delta, "how far apart the two poses of a pair are")
      ->check(kAboveZero)
      ->capture_default_str();
  add_choice(app, "--unit", options.relative.unit, kUnits, "unit of delta: frames, m or deg");
  app.add_flag("--all-pairs", options.relative.all_pairs,
               "every pair that is delta apart, not only consecutive ones");
}

void add_relations_options(CLI::App& app, EvalOptions& options) {
  app.add_option("RELATIONS", options.reference, "file of lines: t1 t2 x y z roll pitch yaw")
      ->required();
  app.add_option("EST", options.estimate, "estimated trajectory, TUM format")->required();
  app.add_option("--time-offset", options.relations.time_offset_s,
                 "added to the trajectory's times (s)")
      ->capture_default_str();
  app.add_flag("--nearest", options.relations.nearest,
               "take the pose nearest to a relation's time instead of interpolating");
  app.add_option("--max-gap", options.relations.max_gap_s,
                 "relations inside a longer gap of the trajectory are unusable (s)")
      ->check(kNotNegative)
      ->capture_default_str();
}

}  // namespace

int parse_command_line(int argc, char** argv, EvalOptions& options) {
  CLI::App app(
      "How good is a trajectory, how good a map? Errors as the evo tool defines them, and how much "
      "was covered.",
      "eval");
  app.require_subcommand(1);
  app.footer(
      "Example: eval ape groundtruth.tum trajectory.tum --align se3 --plot ape.png\n"
      "Returns 0, or 1 when nothing could be computed, or 2 for wrong usage.");
  CLI::App* ape =
      app.add_subcommand("ape", "absolute pose error: is the whole path in the right place?");
  CLI::App* rpe =
      app.add_subcommand("rpe", "relative pose error: how much does it drift from pose to pose?");
  CLI::App* relations = app.add_subcommand(
      "relations",
      "error of verified relative poses (Kuemmerle et al. 2009); needs no reference trajectory");
  CLI::App* map = app.add_subcommand(
      "map",
      "an occupancy map against a reference map: precision, recall, free space, by obstacle");
  add_map_options(*map, options.map);
  map->add_option("--json", options.map.json, "write all numbers to this file")->type_name("FILE");
  std::vector<double> window;
  add_trajectory_options(*ape, options, window);
  add_trajectory_options(*rpe, options, window);
  add_relative_options(*rpe, options);
  add_relations_options(*relations, options);
  for (CLI::App* task : {ape, rpe, relations}) {
    task->add_option("--json", options.json, "write all numbers to this file")->type_name("FILE");
    task->add_option("--report", options.report, kReportHelp)->type_name("FILE.html");
  }
  map->add_option("--report", options.map.report, kReportHelp)->type_name("FILE.html");
  try {
    app.parse(argc, argv);
    if (!window.empty()) {
      if (!(window[0] < window[1]))
        throw CLI::ValidationError("--window", "FROM must be before TO");
      options.evaluation.window = TimeWindow{window[0], window[1]};
    }
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  options.task = ape->parsed()   ? EvalTask::kApe
                 : rpe->parsed() ? EvalTask::kRpe
                 : map->parsed() ? EvalTask::kMap
                                 : EvalTask::kRelations;
  return -1;
}

}  // namespace fusion_slam
