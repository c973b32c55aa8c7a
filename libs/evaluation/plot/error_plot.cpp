#include "libs/evaluation/plot/error_plot.hpp"

#include <algorithm>
#include <fstream>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "libs/evaluation/number_rows.hpp"
#include "libs/evaluation/plot/axes.hpp"
#include "libs/evaluation/plot/canvas.hpp"
#include "libs/evaluation/plot/color_scale.hpp"
#include "libs/evaluation/plot/map_panel.hpp"
#include "libs/evaluation/plot/time_panel.hpp"

namespace fusion_slam {
namespace {

constexpr int kWidth_px = 1400;
constexpr int kHeight_px = 1240;
const cv::Rect2d kMapArea(110, 108, 1110, 700);
const cv::Rect2d kBarArea(1262, 108, 22, 700);
const cv::Rect2d kTimeArea(110, 906, 1110, 260);
constexpr double kLeastScale = 1e-9;  // a plot of perfect agreement still needs a scale

}  // namespace

cv::Mat draw_error_plot(const ErrorPlotData& data) {
  const ErrorPlotText& text = data.text;
  const std::string label =
      text.unit.empty() ? text.error_name : text.error_name + " (" + text.unit + ")";
  const ColorScale scale(rounded_out({0.0, std::max(data.result.statistics.max, kLeastScale)}, 10));

  Canvas canvas(kWidth_px, kHeight_px);
  canvas.text(text.title, {kMapArea.x, 40.0}, {17.0, colors::kInk, Anchor::kLeft, true});
  canvas.text(text.subtitle, {kMapArea.x, 66.0}, {10.5, colors::kSoftInk});
  draw_map_panel(canvas, kMapArea, data, scale);
  draw_color_bar(canvas, kBarArea, scale, label);
  draw_time_panel(canvas, kTimeArea, data, scale.range(), label);
  return canvas.image();
}

std::string png_of(const cv::Mat& image) {
  std::vector<uchar> bytes;
  cv::imencode(".png", image, bytes);
  return {bytes.begin(), bytes.end()};
}

void write_png(const std::filesystem::path& file, const cv::Mat& image) {
  const std::string bytes = png_of(image);
  std::ofstream out(file, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw FileError(file.string(), "can't be written; does the folder exist, is it full?");
}

}  // namespace fusion_slam
