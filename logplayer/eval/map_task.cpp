#include "logplayer/eval/map_task.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <optional>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "libs/evaluation/map_score.hpp"
#include "libs/evaluation/plot/error_plot.hpp"
#include "libs/evaluation/plot/map_plot.hpp"
#include "libs/evaluation/tum_file.hpp"
#include "libs/maps/ros_map_reader.hpp"
#include "logplayer/eval/report_page.hpp"

namespace fusion_slam {
namespace {

using Json = nlohmann::ordered_json;

template <class... Values>
std::string format(const char* pattern, Values... values) {
  char text[512];
  std::snprintf(text, sizeof(text), pattern, values...);
  return text;
}

double percent(double ratio) { return 100.0 * ratio; }

struct MapTaskResult {
  MapRaster reference;
  MapRaster estimate;
  std::vector<std::uint8_t> classes;
  MapAlignment alignment;
  ResampledMap resampled;
  MapScore score;
};

int fail(const std::string& problem) {
  std::cerr << "eval: " << problem << '\n';
  return 1;
}

std::vector<std::uint8_t> read_classes(const std::filesystem::path& file,
                                       const MapRaster& reference) {
  const GreyRaster grey = read_grey(file);
  if (grey.width != reference.width || grey.height != reference.height)
    throw FileError(file.string(),
                    format("has %d x %d cells, the reference map %d x %d: classes and "
                           "map must come from the same ground truth",
                           grey.width, grey.height, reference.width, reference.height));
  for (const std::uint8_t value : grey.values)
    if (value >= kObstacleClasses)
      throw FileError(file.string(), format("has a cell of value %d; classes are 0 to %zu",
                                            int(value), kObstacleClasses - 1));
  return grey.values;
}

std::string describe(const char* role, const std::filesystem::path& file, const MapRaster& raster) {
  return format("  %-10s %s: %d x %d cells of %g m\n", role, file.c_str(), raster.width,
                raster.height, raster.resolution_m);
}

std::string to_table(const MapTaskOptions& options, const MapTaskResult& result) {
  const MapScore& s = result.score;
  std::string table = format("Occupancy map, tolerance %d cell%s\n\n", options.tolerance_cells,
                             options.tolerance_cells == 1 ? "" : "s");
  table += describe("reference", options.reference, result.reference);
  table += describe("estimate", options.estimate, result.estimate);
  const SE2& T = result.alignment.T_ref_est;
  if (options.align.empty())
    table +=
        "  aligned    not: right only when both maps are in one frame; otherwise use --align\n";
  else
    table += format("  %-10s by %zu poses (rmse %.4f m): moved %.3f, %.3f m, turned %.3f deg\n",
                    "aligned", result.alignment.matched, result.alignment.rmse_m, T.x, T.y,
                    T.yaw * 180.0 / M_PI);
  if (result.alignment.tilt_rad > 2.0 * M_PI / 180.0)
    table += format("  %-10s note: the estimated trajectory is tilted by %.1f deg; not corrected\n",
                    "", result.alignment.tilt_rad * 180.0 / M_PI);
  table += "\n  occupied cells\n";
  table += format("    %-16s %6.2f %%   (%zu of %zu estimated)\n", "precision",
                  percent(s.precision()), s.estimate_right, s.estimate_occupied);
  table += format("    %-16s %6.2f %%   (%zu of %zu in the reference)\n", "recall",
                  percent(s.recall()), s.occupied.found, s.occupied.cells);
  table += format("    %-16s %6.2f %%\n    %-16s %6.2f %%\n", "F1", percent(s.f1()), "IoU",
                  percent(s.iou()));
  table += format("    %-16s %zu in free, %zu in unknown space of the reference\n", "false cells",
                  s.false_in_free, s.false_in_unknown);
  table += "  free space\n";
  table += format("    %-16s %6.2f %%   (of the free cells where the estimate has a verdict)\n",
                  "accuracy", percent(s.free_accuracy()));
  table += format("    %-16s %6.2f %%   (free cells with a verdict, of %zu)\n", "coverage",
                  percent(s.free_coverage()), s.reference_free);
  if (result.classes.empty()) return table;
  table += format("\n  %-12s %8s %12s %14s\n", "obstacles", "cells", "recall", "called free");
  for (std::size_t i = 1; i < kObstacleClasses; ++i) {
    const ClassScore& c = s.by_class[i];
    if (c.cells == 0) continue;
    table +=
        format("  %-12s %8zu %10.2f %% %12.2f %%\n", std::string(kObstacleClassNames[i]).c_str(),
               c.cells, percent(c.recall()), percent(double(c.called_free) / double(c.cells)));
  }
  return table;
}

Json to_json(const ClassScore& score) {
  return {{"cells", score.cells},
          {"found", score.found},
          {"called_free", score.called_free},
          {"recall", score.recall()}};
}

Json to_json(const std::filesystem::path& file, const MapRaster& raster) {
  return {{"file", file.string()},
          {"width", raster.width},
          {"height", raster.height},
          {"resolution_m", raster.resolution_m}};
}

Json to_json(const MapTaskOptions& options, const MapTaskResult& result) {
  const MapScore& s = result.score;
  Json json = {{"metric", "map"},
               {"tolerance_cells", options.tolerance_cells},
               {"precision", s.precision()},
               {"recall", s.recall()},
               {"f1", s.f1()},
               {"iou", s.iou()},
               {"estimate_occupied", s.estimate_occupied},
               {"estimate_right", s.estimate_right},
               {"false_in_free", s.false_in_free},
               {"false_in_unknown", s.false_in_unknown},
               {"occupied", to_json(s.occupied)},
               {"free",
                {{"cells", s.reference_free},
                 {"right", s.free_right},
                 {"wrong", s.free_wrong},
                 {"excused", s.free_excused},
                 {"accuracy", s.free_accuracy()},
                 {"coverage", s.free_coverage()}}}};
  if (!result.classes.empty())
    for (std::size_t i = 1; i < kObstacleClasses; ++i)
      json["by_class"][std::string(kObstacleClassNames[i])] = to_json(s.by_class[i]);
  const MapAlignment& a = result.alignment;
  json["alignment"] = {{"by_trajectories", !options.align.empty()},
                       {"x_m", a.T_ref_est.x},
                       {"y_m", a.T_ref_est.y},
                       {"yaw_rad", a.T_ref_est.yaw},
                       {"tilt_rad", a.tilt_rad},
                       {"matched", a.matched},
                       {"rmse_m", a.rmse_m}};
  json["reference"] = to_json(options.reference, result.reference);
  json["estimate"] = to_json(options.estimate, result.estimate);
  return json;
}

void write_json(const std::filesystem::path& file, const Json& json) {
  std::ofstream out(file);
  out << json.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  out.close();
  if (!out) throw FileError(file.string(), "can't be written; does the folder exist, is it full?");
}

}  // namespace

void add_map_options(CLI::App& app, MapTaskOptions& options) {
  app.add_option("REF", options.reference, "reference map, such as truth/map.yaml of `simulate`")
      ->required();
  app.add_option("EST", options.estimate, "estimated map, such as map.yaml of `run`")->required();
  app.add_option(
         "--align", options.align,
         "move the estimated map as its trajectory (TUM) must be moved to fit the reference "
         "one (least squares)")
      ->expected(2)
      ->type_name("REF_TRAJ EST_TRAJ");
  app.add_option("--tolerance-cells", options.tolerance_cells,
                 "cells that lie this far apart are still the same")
      ->check(CLI::Range(0, 20))
      ->capture_default_str();
  app.add_option("--classes", options.classes,
                 "obstacle class of each reference cell (classes.pgm of `simulate --truth`)")
      ->type_name("FILE");
  app.add_option("--max-diff", options.max_diff_s,
                 "poses belong together when their times differ by at most this (s)")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  app.add_option("--plot", options.plot, "draw reference, estimate and difference into this PNG")
      ->type_name("FILE.png");
}

int run_map_task(const MapTaskOptions& options) {
  MapTaskResult result;
  result.reference = read_ros_map(options.reference);
  result.estimate = read_ros_map(options.estimate);
  if (!options.classes.empty()) result.classes = read_classes(options.classes, result.reference);
  if (!options.align.empty()) {
    const auto alignment = align_maps(read_tum(options.align[0]).trajectory,
                                      read_tum(options.align[1]).trajectory, options.max_diff_s);
    if (!alignment) return fail(alignment.problem);
    result.alignment = *alignment;
  }
  auto resampled = resample(result.reference, result.estimate, result.alignment.T_ref_est);
  if (!resampled) return fail(resampled.problem);
  result.resampled = std::move(*resampled.value);
  result.score =
      score_map(result.reference, result.classes, result.resampled, options.tolerance_cells);
  if (!options.json.empty()) write_json(options.json, to_json(options, result));
  const std::string table = to_table(options, result);
  if (!options.plot.empty() || !options.report.empty()) {
    const MapScore& s = result.score;
    const cv::Mat plot =
        draw_map_plot({result.reference, result.classes, result.resampled, s,
                       options.tolerance_cells, "Occupancy map",
                       format("%s   precision %.1f %%   recall %.1f %%   F1 %.1f %%   IoU %.1f "
                              "%%   free space %.1f %%   tolerance %d",
                              options.estimate.filename().c_str(), percent(s.precision()),
                              percent(s.recall()), percent(s.f1()), percent(s.iou()),
                              percent(s.free_accuracy()), options.tolerance_cells)});
    if (!options.plot.empty()) write_png(options.plot, plot);
    if (!options.report.empty())
      write_table_report(options.report, options.estimate.string(), table, png_of(plot));
  }
  std::cout << table;
  return 0;
}

}  // namespace fusion_slam
