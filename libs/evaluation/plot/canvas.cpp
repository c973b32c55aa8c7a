#include "libs/evaluation/plot/canvas.hpp"

#include <cmath>

#include <opencv2/imgproc.hpp>

namespace fusion_slam {
namespace {

constexpr int kZoom = 2;   // sheet pixels for an output pixel
constexpr int kShift = 4;  // OpenCV draws with this many fractional bits
constexpr double kDash_px = 7.0;
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kFontCapital_px = 21.0;  // height of a capital of that font at scale 1

cv::Point fixed(cv::Point2d p) {
  const double scale = kZoom * (1 << kShift);
  return {static_cast<int>(std::lround(p.x * scale)), static_cast<int>(std::lround(p.y * scale))};
}

int stroke(double width_px) { return std::max(1, static_cast<int>(std::lround(width_px * kZoom))); }

double font_scale(const TextStyle& style) { return kZoom * style.height_px / kFontCapital_px; }

int font_stroke(const TextStyle& style) {
  return stroke(style.height_px * (style.bold ? 0.14 : 0.085));
}

cv::Rect on_sheet(cv::Rect2d area) {
  return {
      cv::Point(cvRound(area.x * kZoom), cvRound(area.y * kZoom)),
      cv::Point(cvRound((area.x + area.width) * kZoom), cvRound((area.y + area.height) * kZoom))};
}

}  // namespace

Canvas::Canvas(int width_px, int height_px)
    : sheet_(height_px * kZoom, width_px * kZoom, CV_8UC3, cv::Scalar::all(255)) {}

void Canvas::line(cv::Point2d from, cv::Point2d to, const Color& color, double width_px) {
  cv::line(sheet_, fixed(from), fixed(to), color, stroke(width_px), cv::LINE_AA, kShift);
}

void Canvas::dashed_line(cv::Point2d from, cv::Point2d to, const Color& color, double width_px) {
  const cv::Point2d way = to - from;
  const double length = std::hypot(way.x, way.y);
  const int dashes = static_cast<int>(std::ceil(length / (2.0 * kDash_px)));
  for (int i = 0; i < dashes; ++i) {
    const double at = 2.0 * kDash_px * i;
    const double end = std::min(at + kDash_px, length);
    line(from + way * (at / length), from + way * (end / length), color, width_px);
  }
}

void Canvas::polyline(const std::vector<cv::Point2d>& points, const Color& color, double width_px) {
  std::vector<cv::Point> fixed_points;
  fixed_points.reserve(points.size());
  for (const cv::Point2d& p : points) fixed_points.push_back(fixed(p));
  cv::polylines(sheet_, fixed_points, false, color, stroke(width_px), cv::LINE_AA, kShift);
}

void Canvas::disc(cv::Point2d center, double radius_px, const Color& color) {
  const int radius = static_cast<int>(std::lround(radius_px * kZoom * (1 << kShift)));
  cv::circle(sheet_, fixed(center), radius, color, cv::FILLED, cv::LINE_AA, kShift);
}

void Canvas::fill(cv::Rect2d area, const Color& color) {
  cv::rectangle(sheet_, on_sheet(area), color, cv::FILLED);
}

void Canvas::frame(cv::Rect2d area, const Color& color, double width_px) {
  cv::rectangle(sheet_, on_sheet(area), color, stroke(width_px));
}

void Canvas::text(const std::string& text, cv::Point2d at, const TextStyle& style) {
  const double width = text_width(text, style);
  if (style.anchor == Anchor::kCenter) at.x -= width / 2.0;
  if (style.anchor == Anchor::kRight) at.x -= width;
  cv::putText(sheet_, text, cv::Point(cvRound(at.x * kZoom), cvRound(at.y * kZoom)), kFont,
              font_scale(style), style.color, font_stroke(style), cv::LINE_AA);
}

void Canvas::vertical_text(const std::string& text, cv::Point2d at, const TextStyle& style) {
  const int length_px = static_cast<int>(text_width(text, style)) + 8;
  const int height_px = static_cast<int>(style.height_px * 2.0) + 4;
  Canvas strip(length_px, height_px);
  TextStyle centered = style;
  centered.anchor = Anchor::kCenter;
  strip.text(text, {length_px / 2.0, style.height_px + 4.0}, centered);
  cv::Mat turned;
  cv::rotate(strip.sheet_, turned, cv::ROTATE_90_COUNTERCLOCKWISE);
  const cv::Point corner(cvRound((at.x - style.height_px - 4.0) * kZoom),
                         cvRound((at.y - length_px / 2.0) * kZoom));
  const cv::Rect target = cv::Rect(corner, turned.size()) & cv::Rect({0, 0}, sheet_.size());
  turned(target - corner).copyTo(sheet_(target));
}

double Canvas::text_width(const std::string& text, const TextStyle& style) {
  int baseline = 0;
  return cv::getTextSize(text, kFont, font_scale(style), font_stroke(style), &baseline).width /
         static_cast<double>(kZoom);
}

cv::Mat Canvas::image() const {
  cv::Mat small;
  cv::resize(sheet_, small, {}, 1.0 / kZoom, 1.0 / kZoom, cv::INTER_AREA);
  return small;
}

}  // namespace fusion_slam
