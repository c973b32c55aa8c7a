#include "logplayer/eval/report.hpp"

#include <cstdarg>
#include <cstdio>

#include <nlohmann/json.hpp>

namespace fusion_slam {
namespace {

using Json = nlohmann::ordered_json;

__attribute__((format(printf, 1, 2))) std::string format(const char* pattern, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof(text), pattern, arguments);
  va_end(arguments);
  return text;
}

std::string str(std::string_view view) { return std::string(view); }

double span_s(const Trajectory& trajectory) {
  return trajectory.back().time_s - trajectory.front().time_s;
}

std::string headline(const EvalOptions& options) {
  const std::string relation = str(name_of(options.evaluation.relation));
  if (options.task == EvalTask::kApe) return "Absolute pose error, " + relation;
  return "Relative pose error over " + format("%g ", options.relative.delta) +
         str(name_of(options.relative.unit)) +
         (options.relative.all_pairs ? " (all pairs), " : ", ") + relation;
}

std::string unit_suffix(const EvalOptions& options) {
  const std::string unit = str(unit_of(options.evaluation.relation));
  return unit.empty() ? "" : " (" + unit + ")";
}

std::string describe_file(const char* role, const std::filesystem::path& file, const TumFile& tum) {
  std::string line = format("  %-10s %s: %zu poses, %.2f s\n", role, file.c_str(),
                            tum.trajectory.size(), span_s(tum.trajectory));
  if (tum.out_of_order > 0) {
    line += format("  %-10s note: not in the order of time in %zu places; sorted\n", "",
                   tum.out_of_order);
  }
  if (tum.repeated > 0) {
    line += format("  %-10s note: a time is repeated in %zu places\n", "", tum.repeated);
  }
  return line;
}

std::string statistics_rows(const Statistics& statistics) {
  std::string rows;
  for (const auto& [name, value] : statistics.named()) {
    rows += format("  %-10s %.6f\n", str(name).c_str(), value);
  }
  return rows;
}

Json to_json(const Statistics& statistics) {
  Json json;
  for (const auto& [name, value] : statistics.named()) json[str(name)] = value;
  return json;
}

Json to_json(const std::filesystem::path& file, const TumFile& tum) {
  return {{"file", file.string()},
          {"poses", tum.trajectory.size()},
          {"start_s", tum.trajectory.front().time_s},
          {"end_s", tum.trajectory.back().time_s},
          {"out_of_order", tum.out_of_order},
          {"repeated", tum.repeated}};
}

Json to_json(const Coverage& coverage) {
  return {{"percent", coverage.percent},
          {"covered_s", coverage.covered_s},
          {"window_start_s", coverage.window.begin_s},
          {"window_end_s", coverage.window.end_s},
          {"allowed_gap_s", coverage.allowed_gap_s},
          {"longest_gap_s", coverage.longest_gap_s}};
}

Json to_json(Alignment kind, const Similarity& S) {
  const Eigen::Vector3d& t = S.T_to_from.translation();
  const Eigen::Quaterniond q(S.T_to_from.linear());
  return {{"kind", str(name_of(kind))},
          {"scale", S.scale},
          {"translation_m", {t.x(), t.y(), t.z()}},
          {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

}  // namespace

std::string to_table(const EvalOptions& options, const TumFile& reference, const TumFile& estimate,
                     const TrajectoryError& result) {
  const Coverage& coverage = result.coverage;
  std::string table = headline(options) + unit_suffix(options) + "\n\n";
  table += describe_file("reference", options.reference, reference);
  table += describe_file("estimate", options.estimate, estimate);
  table += format("  %-10s %zu of %zu estimated poses within %g s of a reference pose\n", "matched",
                  result.matched.size(), estimate.trajectory.size(), options.evaluation.max_diff_s);
  table += format("  %-10s %.2f %% of %.2f s; longest time without a pose %.2f s\n", "coverage",
                  coverage.percent, coverage.window.length_s(), coverage.longest_gap_s);
  const Alignment alignment = options.evaluation.alignment;
  table += format("  %-10s %s", "aligned", str(name_of(alignment)).c_str());
  table += alignment == Alignment::kSim3 ? format(", scale %.6f\n", result.alignment.scale) : "\n";
  table += format("  %-10s %zu\n\n", options.task == EvalTask::kApe ? "compared" : "pairs",
                  result.statistics.count);
  table += statistics_rows(result.statistics);
  if (options.task == EvalTask::kApe && alignment == Alignment::kNone) {
    table += "\nNot aligned: right only when both are in one frame; otherwise use --align se3.\n";
  }
  return table;
}

Json to_json(const EvalOptions& options, const TumFile& reference, const TumFile& estimate,
             const TrajectoryError& result) {
  Json json = {{"metric", options.task == EvalTask::kApe ? "ape" : "rpe"},
               {"relation", str(name_of(options.evaluation.relation))},
               {"unit", str(unit_of(options.evaluation.relation))}};
  if (options.task == EvalTask::kRpe) {
    json["delta"] = options.relative.delta;
    json["delta_unit"] = str(name_of(options.relative.unit));
    json["all_pairs"] = options.relative.all_pairs;
  }
  json["statistics"] = to_json(result.statistics);
  json["compared"] = result.statistics.count;
  json["coverage_percent"] = result.coverage.percent;
  json["coverage"] = to_json(result.coverage);
  json["max_diff_s"] = options.evaluation.max_diff_s;
  json["matched"] = result.matched.size();
  json["alignment"] = to_json(options.evaluation.alignment, result.alignment);
  json["reference"] = to_json(options.reference, reference);
  json["estimate"] = to_json(options.estimate, estimate);
  return json;
}

ErrorPlotText to_plot_text(const EvalOptions& options, const TrajectoryError& result) {
  const std::string unit = str(unit_of(options.evaluation.relation));
  ErrorPlotText text;
  text.title = headline(options);
  text.unit = unit;
  text.error_name = options.evaluation.relation == ErrorRelation::kFull
                        ? "|E - I|"
                        : str(name_of(options.evaluation.relation)) + " error";
  text.subtitle =
      options.estimate.filename().string() + "   RMSE " +
      format("%.4g %s   max %.4g %s   coverage %.1f %%   aligned: %s   %zu compared",
             result.statistics.rmse, unit.c_str(), result.statistics.max, unit.c_str(),
             result.coverage.percent, str(name_of(options.evaluation.alignment)).c_str(),
             result.statistics.count);
  return text;
}

std::string to_table(const EvalOptions& options, const TumFile& estimate,
                     const RelationsError& result) {
  std::string table = "Error of verified relations\n\n";
  table +=
      format("  %-10s %s: %zu relations\n", "relations", options.reference.c_str(), result.total);
  table += describe_file("estimate", options.estimate, estimate);
  table +=
      format("  %-10s %zu of %zu relations usable (%.2f %%), time offset %g s, %s\n\n", "coverage",
             result.usable, result.total, result.usable_percent(), options.relations.time_offset_s,
             options.relations.nearest ? "nearest poses" : "interpolated poses");
  table += format("  %-10s %16s %16s\n", "", "translation (m)", "rotation (deg)");
  const auto translation = result.translation_m.named();
  const auto rotation = result.rotation_deg.named();
  for (std::size_t i = 0; i < translation.size(); ++i) {
    table += format("  %-10s %16.6f %16.6f\n", str(translation[i].first).c_str(),
                    translation[i].second, rotation[i].second);
  }
  return table;
}

Json to_json(const EvalOptions& options, const TumFile& estimate, const RelationsError& result) {
  return {{"metric", "relations"},
          {"translation_m", to_json(result.translation_m)},
          {"rotation_deg", to_json(result.rotation_deg)},
          {"usable", result.usable},
          {"total", result.total},
          {"coverage_percent", result.usable_percent()},
          {"time_offset_s", options.relations.time_offset_s},
          {"nearest", options.relations.nearest},
          {"max_gap_s", options.relations.max_gap_s},
          {"relations", {{"file", options.reference.string()}}},
          {"estimate", to_json(options.estimate, estimate)}};
}

}  // namespace fusion_slam
