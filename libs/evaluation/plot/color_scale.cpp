#include "libs/evaluation/plot/color_scale.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace fusion_slam {
namespace {

constexpr double kPalestShare = 0.92;
constexpr double kLabelOffset_px = 96.0;

}  // namespace

ColorScale::ColorScale(Range range) : range_(range) {
  cv::Mat ramp(256, 1, CV_8UC1);
  for (int i = 0; i < 256; ++i) ramp.at<uchar>(i) = static_cast<uchar>((255 - i) * kPalestShare);
  cv::applyColorMap(ramp, table_, cv::COLORMAP_VIRIDIS);
}

Color ColorScale::operator()(double error) const {
  const double share = std::clamp((error - range_.low) / range_.length(), 0.0, 1.0);
  const auto& bgr = table_.at<cv::Vec3b>(static_cast<int>(std::lround(share * 255.0)));
  return {double(bgr[0]), double(bgr[1]), double(bgr[2])};
}

void draw_color_bar(Canvas& canvas, const cv::Rect2d& area_px, const ColorScale& scale,
                    const std::string& label) {
  for (int row = 0; row < static_cast<int>(area_px.height); ++row) {
    const double share = 1.0 - (row + 0.5) / area_px.height;
    canvas.fill({area_px.x, area_px.y + row, area_px.width, 1.0},
                scale(scale.range().low + share * scale.range().length()));
  }
  canvas.frame(area_px, colors::kFrame, 1.0);
  const Axes axes(area_px, {0.0, 1.0}, scale.range());
  const std::vector<double> values = ticks(scale.range(), 10);
  const std::vector<std::string> labels = tick_labels(values);
  for (std::size_t i = 0; i < values.size(); ++i) {
    canvas.text(labels[i], {area_px.x + area_px.width + 8.0, axes.at(0, values[i]).y + 4.5},
                {9.5, colors::kSoftInk});
  }
  canvas.vertical_text(label, {area_px.x + kLabelOffset_px, area_px.y + area_px.height / 2.0},
                       {10.5, colors::kInk});
}

}  // namespace fusion_slam
