#include "logplayer/report/report.hpp"

#include <fstream>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "libs/maps/atomic_file.hpp"
#include "libs/report/page.hpp"
#include "logplayer/report/accuracy.hpp"
#include "logplayer/report/session_history.hpp"
#include "logplayer/report/session_sections.hpp"

namespace fusion_slam {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

Json read_metrics(const fs::path& folder) {
  const fs::path file = folder / "metrics.json";
  std::ifstream in(file);
  if (!in)
    throw std::runtime_error(file.string() + ": not there; give the folder that `fusion-slam run " +
                             "LOG --out FOLDER` left");
  try {
    Json json = Json::parse(in);
    if (!json.is_object()) throw std::runtime_error("no object");
    return json;
  } catch (const std::exception& error) {
    throw std::runtime_error(file.string() + ": " + error.what() + "; run again");
  }
}

double value_of(const Json& json, const char* key, double otherwise = 0.0) {
  return json.contains(key) && json[key].is_number() ? json[key].get<double>() : otherwise;
}

std::vector<Fact> facts_of(const Json& m) {
  std::vector<Fact> facts;
  const double coverage = value_of(m, "coverage_percent");
  facts.push_back({"Coverage", number(coverage, 1) + " %", "of the sensor's times have a pose",
                   coverage < 95.0});
  if (m.contains("ape_rmse_m"))
    facts.push_back(
        {"APE", number(value_of(m, "ape_rmse_m"), 4) + " m", "RMSE, aligned by SE(3)", false});
  if (m.contains("rpe_rmse_m"))
    facts.push_back(
        {"RPE", number(value_of(m, "rpe_rmse_m"), 4) + " m", "RMSE, frame to frame", false});
  if (m.contains("relations_translation_mean_m"))
    facts.push_back({"Relations", number(value_of(m, "relations_translation_mean_m"), 4) + " m",
                     number(value_of(m, "relations_rotation_mean_deg"), 2) + " deg, " +
                         number(value_of(m, "relations_used"), 0) + " of " +
                         number(value_of(m, "relations_total"), 0),
                     false});
  facts.push_back({"Way", number(value_of(m, "path_length_m"), 1) + " m",
                   number(value_of(m, "duration_s"), 1) + " s", false});
  facts.push_back({"Real-time factor", number(value_of(m, "real_time_factor"), 2) + " x",
                   number(value_of(m, "wall_s"), 1) + " s", false});
  facts.push_back({"Free floor", number(value_of(m, "free_area_m2"), 1) + " m\u00b2",
                   number(value_of(m, "occupied_area_m2"), 1) + " m\u00b2 occupied", false});
  const double dropped = value_of(m, "dropped_total"), lost = value_of(m, "lost_total");
  facts.push_back({"Dropped, lost", number(dropped, 0) + ", " + number(lost, 0),
                   "messages between processes", dropped + lost > 0.0});
  return facts;
}

std::string text_of(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  return value.is_number_float() ? number(value.get<double>(), 4) : value.dump();
}

Section numbers_section(const Json& metrics) {
  HtmlTable table{{"name", "value"}, {}};
  for (const auto& [key, value] : metrics.items())
    if (!value.is_structured()) table.rows.push_back({key, text_of(value)});
  std::string body = table_html(table);
  if (metrics.contains("channels") && metrics["channels"].is_object()) {
    HtmlTable channels{{"channel", "messages"}, {}};
    for (const auto& [key, value] : metrics["channels"].items())
      channels.rows.push_back({key, text_of(value)});
    body += table_html(channels);
  }
  return {"Numbers", "All of metrics.json that is a single value, and the messages by channel.",
          "<details><summary>show</summary>\n" + body + "</details>\n"};
}

}  // namespace

fs::path write_report(const ReportOptions& options) {
  const Json metrics = read_metrics(options.run);
  Page page;
  const std::string log = metrics.contains("log") ? text_of(metrics["log"]) : "a recording";
  page.title = fs::path(log).stem().string();
  page.subtitle = "Fusion-SLAM run of " + log +
                  (metrics.contains("mode") ? ", " + text_of(metrics["mode"]) : std::string());
  page.facts = facts_of(metrics);
  if (metrics.contains("complete") && metrics["complete"] == false)
    page.problems.emplace_back("The run did not come to its end: these are the results so far.");
  if (metrics.contains("evaluation_problem"))
    page.problems.push_back("No accuracy: " + text_of(metrics["evaluation_problem"]));
  const Accuracy accuracy = read_accuracy(options.run);
  page.sections.push_back(map_section(options.run, options.truth_map, accuracy));
  if (accuracy.ape) page.sections.push_back(error_section(accuracy));
  const fs::path session = options.run / "session.lcmlog";
  if (fs::exists(session)) {
    const SessionHistory history = read_history(session);
    if (!history.damage.empty()) page.problems.push_back("session.lcmlog: " + history.damage);
    page.sections.push_back(process_section(history));
    page.sections.push_back(loop_section(session, history, accuracy.estimate));
    page.sections.push_back(settings_section(history));
  } else {
    page.problems.emplace_back(
        "No session.lcmlog in the folder: no processes, loops and settings here.");
  }
  page.sections.push_back(numbers_section(metrics));
  fs::path out = options.out.empty() ? options.run / "report.html" : options.out;
  write_file_atomically(out, page_html(page));
  return out;
}

}  // namespace fusion_slam
