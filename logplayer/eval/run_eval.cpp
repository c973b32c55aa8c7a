#include "logplayer/eval/run_eval.hpp"

#include <fstream>
#include <iostream>

#include <nlohmann/json.hpp>

#include "libs/evaluation/tum_file.hpp"
#include "logplayer/eval/report.hpp"
#include "logplayer/eval/report_page.hpp"

namespace fusion_slam {
namespace {

void write_json(const std::filesystem::path& file, const nlohmann::ordered_json& json) {
  if (file.empty()) return;
  std::ofstream out(file);
  out << json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
  out.close();
  if (!out) throw FileError(file.string(), "can't be written; does the folder exist, is it full?");
}

int fail(const std::string& problem) {
  std::cerr << "eval: " << problem << '\n';
  return 1;
}

int run_relations(const EvalOptions& options) {
  const std::vector<PoseRelation> relations = read_relations(options.reference);
  const TumFile estimate = read_tum(options.estimate);
  const auto result = evaluate_relations(relations, estimate.trajectory, options.relations);
  if (!result) return fail(result.problem);
  write_json(options.json, to_json(options, estimate, *result));
  const std::string table = to_table(options, estimate, *result);
  if (!options.report.empty())
    write_table_report(options.report, options.estimate.filename().string() + ": relations", table,
                       "");
  std::cout << table;
  return 0;
}

int run_trajectory_error(const EvalOptions& options) {
  const TumFile reference = read_tum(options.reference);
  const TumFile estimate = read_tum(options.estimate);
  const auto result =
      options.task == EvalTask::kApe
          ? evaluate_ape(reference.trajectory, estimate.trajectory, options.evaluation)
          : evaluate_rpe(reference.trajectory, estimate.trajectory, options.evaluation,
                         options.relative);
  if (!result) return fail(result.problem);
  write_json(options.json, to_json(options, reference, estimate, *result));
  if (!options.plot.empty()) {
    write_png(options.plot, draw_error_plot({*result, reference.trajectory, estimate.trajectory,
                                             to_plot_text(options, *result)}));
  }
  const std::string table = to_table(options, reference, estimate, *result);
  if (!options.report.empty()) write_error_report(options, reference, estimate, *result, table);
  std::cout << table;
  return 0;
}

}  // namespace

int run_eval(const EvalOptions& options) {
  if (options.task == EvalTask::kMap) return run_map_task(options.map);
  return options.task == EvalTask::kRelations ? run_relations(options)
                                              : run_trajectory_error(options);
}

}  // namespace fusion_slam
