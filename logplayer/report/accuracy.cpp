#include "logplayer/report/accuracy.hpp"

#include <opencv2/imgcodecs.hpp>

#include "libs/evaluation/tum_file.hpp"
#include "libs/grid/cell_state.hpp"
#include "libs/maps/ros_map_reader.hpp"
#include "libs/report/chart.hpp"
#include "libs/report/top_view.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

Trajectory trajectory_of(const fs::path& file) {
  return fs::exists(file) ? read_tum(file).trajectory : Trajectory{};
}

std::vector<Eigen::Vector2d> ground_of(const Trajectory& trajectory) {
  std::vector<Eigen::Vector2d> points;
  for (const StampedPose& pose : trajectory)
    points.emplace_back(pose.T_world_body.translation().head<2>());
  return points;
}

// Free is white, occupied dark, unknown nothing: the page's colour shows.
MapImage image_of(const MapRaster& map) {
  cv::Mat picture(map.height, map.width, CV_8UC4, cv::Scalar(0, 0, 0, 0));
  for (int row = 0; row < map.height; ++row)
    for (int column = 0; column < map.width; ++column) {
      const CellState state = state_of_cell(map.probability[map.index(column, row)]);
      auto& pixel = picture.at<cv::Vec4b>(map.height - 1 - row, column);
      if (state == CellState::kUnoccupied) pixel = {255, 255, 255, 255};
      if (state == CellState::kOccupied) pixel = {60, 44, 34, 255};
    }
  std::vector<std::uint8_t> png;
  cv::imencode(".png", picture, png);
  return {std::string(png.begin(), png.end()), map.origin_x_m, map.origin_y_m,
          map.width * map.resolution_m, map.height * map.resolution_m};
}

std::string figure(const std::string& svg) { return "<figure>" + svg + "</figure>\n"; }

Series over_time(const std::string& name, const TrajectoryError& error) {
  Series series{name, {}};
  const double start_s = error.matched.reference.front().time_s;
  for (const ErrorSample& sample : error.samples)
    series.points.emplace_back(error.matched.estimate[sample.to].time_s - start_s, sample.error);
  return series;
}

std::vector<double> errors_of(const TrajectoryError& error) {
  std::vector<double> errors;
  for (const ErrorSample& sample : error.samples) errors.push_back(sample.error);
  return errors;
}

// The matched part of the estimate in its own map or, aligned, in the reference's frame.
Way estimated_way(const Accuracy& accuracy, bool aligned) {
  if (!accuracy.ape) return {"estimated way", "plain", ground_of(accuracy.estimate), {}};
  const Similarity& S = accuracy.ape->alignment;
  Trajectory way = accuracy.ape->matched.estimate;
  if (!aligned)
    for (StampedPose& pose : way) pose.T_world_body = S.T_to_from.inverse() * pose.T_world_body;
  return {"estimate", "way", ground_of(way), errors_of(*accuracy.ape)};
}

Way true_way(const Accuracy& accuracy, bool aligned) {
  Trajectory way = accuracy.reference;
  if (!aligned)
    for (StampedPose& pose : way)
      pose.T_world_body = accuracy.ape->alignment.T_to_from.inverse() * pose.T_world_body;
  return {"ground truth", "truth", ground_of(way), {}};
}

}  // namespace

Accuracy read_accuracy(const fs::path& run) {
  Accuracy accuracy;
  accuracy.estimate = trajectory_of(run / "trajectory.tum");
  accuracy.reference = trajectory_of(run / "groundtruth.tum");
  if (accuracy.estimate.empty() || accuracy.reference.empty()) return accuracy;
  EvaluationOptions options;
  options.alignment = Alignment::kSe3;
  accuracy.ape = evaluate_ape(accuracy.reference, accuracy.estimate, options).value;
  accuracy.rpe = evaluate_rpe(accuracy.reference, accuracy.estimate, options, {}).value;
  return accuracy;
}

Section map_section(const fs::path& run, const fs::path& truth_map, const Accuracy& accuracy) {
  TopView view{"Estimated map", std::nullopt, {}, {}, 0.0};
  if (fs::exists(run / "map.yaml")) view.map = image_of(read_ros_map(run / "map.yaml"));
  if (accuracy.ape) view.ways.push_back(true_way(accuracy, false));
  view.ways.push_back(estimated_way(accuracy, false));
  std::string body = figure(top_view_svg(view));
  if (!truth_map.empty()) {
    TopView truth{"True map", image_of(read_ros_map(truth_map)), {}, {}, 0.0};
    if (accuracy.ape) {
      truth.ways.push_back(true_way(accuracy, true));
      truth.ways.push_back(estimated_way(accuracy, true));
    }
    body += figure(top_view_svg(truth));
  }
  return {"Map",
          "White is free, dark is occupied, the rest is unknown. The way is coloured by its error "
          "where there is a ground truth.",
          "<div class=\"figures\">" + body + "</div>\n"};
}

Section error_section(const Accuracy& accuracy) {
  std::string body = figure(
      line_chart_svg({"Absolute pose error", "time, s", "m", {over_time("APE", *accuracy.ape)}}));
  if (accuracy.rpe)
    body += figure(line_chart_svg({"Relative pose error, frame to frame",
                                   "time, s",
                                   "m",
                                   {over_time("RPE", *accuracy.rpe)}}));
  body += figure(histogram_svg({"Absolute pose error", "error, m", errors_of(*accuracy.ape)}));
  if (accuracy.rpe)
    body += figure(histogram_svg({"Relative pose error", "error, m", errors_of(*accuracy.rpe)}));
  HtmlTable table{{"", "RMSE", "mean", "median", "std", "max", "n"}, {}};
  const auto add = [&](const char* name, const TrajectoryError& e) {
    const Statistics& s = e.statistics;
    table.rows.push_back({name, number(s.rmse, 4), number(s.mean, 4), number(s.median, 4),
                          number(s.std, 4), number(s.max, 4), std::to_string(s.count)});
  };
  add("APE, m", *accuracy.ape);
  if (accuracy.rpe) add("RPE, m", *accuracy.rpe);
  return {"Error against the ground truth",
          "Aligned by least squares over all matched positions (Umeyama 1991), rotation and "
          "translation. Coverage of the reference: " +
              number(accuracy.ape->coverage.percent, 1) + " %.",
          "<div class=\"figures\">" + body + "</div>\n" + table_html(table)};
}

}  // namespace fusion_slam
