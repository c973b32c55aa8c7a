// One picture of an evaluation: above, reference and aligned estimate from the top, the estimate
// coloured by its error; below, the error over time, with the times without an estimate marked.
#pragma once

#include <filesystem>
#include <string>

#include <opencv2/core.hpp>

#include "libs/evaluation/trajectory_error.hpp"

namespace fusion_slam {

struct ErrorPlotText {
  std::string title;       // "Absolute pose error, translation"
  std::string subtitle;    // one line of facts
  std::string error_name;  // "translation error"
  std::string unit;        // "m", "deg" or ""
};

// What evaluate_ape() or evaluate_rpe() returned, and the two trajectories it was given.
struct ErrorPlotData {
  const TrajectoryError& result;
  const Trajectory& reference;
  const Trajectory& estimate;
  ErrorPlotText text;
};

// The plane shown is x-y (the top view of a robot's map), unless the reference hardly moves along x
// or y: then the two axes along which it moves most. 1400 x 1240 pixels, BGR.
cv::Mat draw_error_plot(const ErrorPlotData& data);

// Throws FileError (number_rows.hpp) when the file can't be written.
std::string png_of(const cv::Mat& image);
void write_png(const std::filesystem::path& file, const cv::Mat& image);

}  // namespace fusion_slam
