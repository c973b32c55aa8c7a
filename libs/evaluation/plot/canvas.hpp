// A white sheet to draw on, in output pixels with fractions. It is drawn four times as large in
// area and scaled down at the end, which makes OpenCV's stroke fonts and thin lines smooth.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace fusion_slam {

using Color = cv::Scalar;  // blue, green, red

namespace colors {
inline const Color kPaper(255, 255, 255);
inline const Color kInk(40, 36, 33);
inline const Color kSoftInk(125, 117, 108);
inline const Color kGrid(238, 234, 230);
inline const Color kFrame(190, 182, 175);
inline const Color kReference(176, 168, 160);
inline const Color kGap(214, 226, 250);
}  // namespace colors

enum class Anchor { kLeft, kCenter, kRight };

struct TextStyle {
  double height_px = 13.0;  // of a capital letter, about
  Color color = colors::kInk;
  Anchor anchor = Anchor::kLeft;
  bool bold = false;
};

class Canvas {
 public:
  Canvas(int width_px, int height_px);

  void line(cv::Point2d from, cv::Point2d to, const Color& color, double width_px);
  void dashed_line(cv::Point2d from, cv::Point2d to, const Color& color, double width_px);
  void polyline(const std::vector<cv::Point2d>& points, const Color& color, double width_px);
  void disc(cv::Point2d center, double radius_px, const Color& color);
  void fill(cv::Rect2d area, const Color& color);
  void frame(cv::Rect2d area, const Color& color, double width_px);
  // `at` is where the baseline starts, has its middle, or ends, by style.anchor.
  void text(const std::string& text, cv::Point2d at, const TextStyle& style);
  // Reads upwards; `at` is the middle of the baseline.
  void vertical_text(const std::string& text, cv::Point2d at, const TextStyle& style);
  static double text_width(const std::string& text, const TextStyle& style);

  cv::Mat image() const;  // 8-bit BGR of the size asked for

 private:
  cv::Mat sheet_;
};

}  // namespace fusion_slam
