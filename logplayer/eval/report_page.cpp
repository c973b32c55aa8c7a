#include "logplayer/eval/report_page.hpp"

#include "libs/maps/atomic_file.hpp"
#include "libs/report/chart.hpp"
#include "libs/report/page.hpp"
#include "logplayer/report/accuracy.hpp"
#include "logplayer/report/session_history.hpp"
#include "logplayer/report/session_sections.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

std::string in_full(const std::string& table) { return "<pre>" + escape_html(table) + "</pre>\n"; }

std::string unit_text(ErrorRelation relation) {
  if (relation == ErrorRelation::kTranslation) return "m";
  return relation == ErrorRelation::kRotation ? "deg" : "";
}

std::vector<Fact> facts_of(const TrajectoryError& result, const std::string& unit) {
  const Statistics& s = result.statistics;
  const auto value = [&](double error) { return number(error, 4) + " " + unit; };
  return {{"RMSE", value(s.rmse), "of " + std::to_string(s.count) + " errors", false},
          {"Median", value(s.median), "mean " + value(s.mean), false},
          {"Largest", value(s.max), "standard deviation " + value(s.std), false},
          {"Coverage", number(result.coverage.percent, 1) + " %", "of the reference",
           result.coverage.percent < 95.0}};
}

Section error_over_time(const EvalOptions& options, const TrajectoryError& result,
                        const std::string& unit) {
  const bool ape = options.task == EvalTask::kApe;
  const std::string title = ape ? "Absolute pose error" : "Relative pose error";
  Series series{ape ? "APE" : "RPE", {}};
  std::vector<double> errors;
  const double start_s = result.matched.reference.front().time_s;
  for (const ErrorSample& sample : result.samples) {
    series.points.emplace_back(result.matched.estimate[sample.to].time_s - start_s, sample.error);
    errors.push_back(sample.error);
  }
  return {"Error",
          "Aligned: " + std::string(name_of(options.evaluation.alignment)) +
              ". Compared: " + std::string(name_of(options.evaluation.relation)) + ".",
          "<div class=\"figures\"><figure>" + line_chart_svg({title, "time, s", unit, {series}}) +
              "</figure>\n<figure>" + histogram_svg({title, "error, " + unit, errors}) +
              "</figure></div>\n"};
}

}  // namespace

void write_error_report(const EvalOptions& options, const TumFile& reference,
                        const TumFile& estimate, const TrajectoryError& result,
                        const std::string& table) {
  const std::string unit = unit_text(options.evaluation.relation);
  const bool ape = options.task == EvalTask::kApe;
  Page page;
  page.title = options.estimate.filename().string();
  page.subtitle = std::string(ape ? "Absolute" : "Relative") + " pose error of " +
                  options.estimate.string() + " against " + options.reference.string();
  page.facts = facts_of(result, unit);
  const fs::path folder = options.estimate.parent_path();
  if (ape && options.evaluation.relation == ErrorRelation::kTranslation) {
    const Accuracy accuracy{estimate.trajectory, reference.trajectory, result, {}};
    page.sections.push_back(map_section(folder, {}, accuracy));
  }
  page.sections.push_back(error_over_time(options, result, unit));
  if (fs::exists(folder / "session.lcmlog")) {
    const SessionHistory history = read_history(folder / "session.lcmlog");
    page.sections.push_back(process_section(history));
    page.sections.push_back(loop_section(folder / "session.lcmlog", history, estimate.trajectory));
    page.sections.push_back(settings_section(history));
  }
  page.sections.push_back({"Numbers", "As eval prints them.", in_full(table)});
  write_file_atomically(options.report, page_html(page));
}

void write_table_report(const fs::path& file, const std::string& title, const std::string& table,
                        const std::string& png) {
  Page page;
  page.title = title;
  if (!png.empty())
    page.sections.push_back({"Picture", "",
                             "<figure><img alt=\"" + escape_html(title) +
                                 "\" src=\"data:image/png;base64," + base64(png) +
                                 "\"></figure>\n"});
  page.sections.push_back({"Numbers", "As eval prints them.", in_full(table)});
  write_file_atomically(file, page_html(page));
}

}  // namespace fusion_slam
