#include "libs/evaluation/plot/map_plot.hpp"

#include <algorithm>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "libs/evaluation/plot/canvas.hpp"

namespace fusion_slam {
namespace {

// Blue, green, red; the strong ones are of Okabe & Ito's palette (2008).
const cv::Vec3b kUnknown(205, 205, 205);
const cv::Vec3b kFree(252, 252, 252);
const cv::Vec3b kFreeUnseen(236, 228, 222);
const cv::Vec3b kRight(60, 60, 60);
const cv::Vec3b kFalse(0, 94, 213);
const cv::Vec3b kMissed(178, 114, 0);
const cv::Vec3b kClasses[kObstacleClasses] = {{0, 0, 0},    {70, 70, 70},  {178, 114, 0},
                                              {0, 94, 213}, {115, 158, 0}, {0, 159, 230}};

constexpr int kWidth = 1500, kMargin = 20, kTop = 92, kBottom = 46, kMaxHeight = 1500;
constexpr int kPanelWidth = (kWidth - 4 * kMargin) / 3;

using Picture = cv::Mat_<cv::Vec3b>;

bool any_near(const MapPlotData& data, int column, int row, bool reference) {
  for (int dy = -data.tolerance_cells; dy <= data.tolerance_cells; ++dy)
    for (int dx = -data.tolerance_cells; dx <= data.tolerance_cells; ++dx) {
      const int c = column + dx, r = row + dy;
      if (!reference) {
        if (data.estimate.at(c, r) == CellState::kOccupied) return true;
      } else if (c >= 0 && r >= 0 && c < data.reference.width && r < data.reference.height &&
                 state_of_cell(data.reference.probability[data.reference.index(c, r)]) ==
                     CellState::kOccupied) {
        return true;
      }
    }
  return false;
}

cv::Vec3b difference(const MapPlotData& data, int column, int row, CellState truth,
                     CellState said) {
  if (said == CellState::kOccupied) return any_near(data, column, row, true) ? kRight : kFalse;
  if (truth == CellState::kOccupied) return any_near(data, column, row, false) ? kRight : kMissed;
  if (truth == CellState::kUnoccupied) return said == CellState::kUnoccupied ? kFree : kFreeUnseen;
  return kUnknown;
}

// Truth, estimate, difference; first row is the largest y.
std::array<Picture, 3> paint(const MapPlotData& data) {
  const ResampledMap& map = data.estimate;
  std::array<Picture, 3> panels;
  for (Picture& panel : panels) panel = Picture(map.height, map.width, kUnknown);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const int column = map.first_column + x, row = map.first_row + y;
      const bool inside =
          column >= 0 && row >= 0 && column < data.reference.width && row < data.reference.height;
      const std::size_t i = inside ? data.reference.index(column, row) : 0;
      const CellState truth =
          inside ? state_of_cell(data.reference.probability[i]) : CellState::kUnknown;
      const CellState said = map.at(column, row);
      const cv::Point at(x, map.height - 1 - y);
      if (truth == CellState::kUnoccupied) panels[0](at) = kFree;
      if (truth == CellState::kOccupied)
        panels[0](at) = kClasses[data.classes.empty() ? 0
                                                      : std::min<std::size_t>(
                                                            data.classes[i], kObstacleClasses - 1)];
      if (said == CellState::kUnoccupied) panels[1](at) = kFree;
      if (said == CellState::kOccupied) panels[1](at) = cv::Vec3b(0, 0, 0);
      panels[2](at) = difference(data, column, row, truth, said);
    }
  return panels;
}

void legend(Canvas& canvas, cv::Point2d at,
            const std::vector<std::pair<std::string, cv::Vec3b>>& entries) {
  TextStyle style;
  style.height_px = 11.0;
  for (const auto& [name, colour] : entries) {
    const cv::Rect2d square(at.x, at.y - 11.0, 12.0, 12.0);
    canvas.fill(square, Color(colour[0], colour[1], colour[2]));
    canvas.frame(square, colors::kFrame, 1.0);
    canvas.text(name, {at.x + 18.0, at.y}, style);
    at.x += 34.0 + Canvas::text_width(name, style);
  }
}

}  // namespace

cv::Mat draw_map_plot(const MapPlotData& data) {
  const std::array<Picture, 3> panels = paint(data);
  const double scale = std::min(double(kPanelWidth) / data.estimate.width,
                                double(kMaxHeight - kTop - kBottom) / data.estimate.height);
  const cv::Size size(std::max(1, int(data.estimate.width * scale)),
                      std::max(1, int(data.estimate.height * scale)));
  Canvas canvas(kWidth, kTop + size.height + kBottom);
  TextStyle style;
  style.bold = true;
  style.height_px = 16.0;
  canvas.text(data.title, {kMargin, 32.0}, style);
  style.bold = false;
  style.height_px = 12.0;
  style.color = colors::kSoftInk;
  canvas.text(data.subtitle, {kMargin, 56.0}, style);
  style.color = colors::kInk;
  const char* names[] = {"reference", "estimate", "difference"};
  const auto left = [](int i) { return kMargin + i * (kPanelWidth + kMargin); };
  for (int i = 0; i < 3; ++i) canvas.text(names[i], {double(left(i)), kTop - 10.0}, style);
  const double below = kTop + size.height + 28.0;
  std::vector<std::pair<std::string, cv::Vec3b>> classes;
  if (!data.classes.empty())
    for (std::size_t i = 1; i < kObstacleClasses; ++i)
      classes.emplace_back(kObstacleClassNames[i], kClasses[i]);
  legend(canvas, {double(left(0)), below}, classes);
  legend(canvas, {double(left(1)), below},
         {{"occupied", {0, 0, 0}}, {"free", kFree}, {"unknown", kUnknown}});
  legend(
      canvas, {double(left(2)), below},
      {{"right", kRight}, {"false", kFalse}, {"missed", kMissed}, {"free, unseen", kFreeUnseen}});
  cv::Mat image = canvas.image();
  for (int i = 0; i < 3; ++i) {
    cv::Mat scaled;
    cv::resize(panels[std::size_t(i)], scaled, size, 0, 0,
               scale < 1.0 ? cv::INTER_AREA : cv::INTER_NEAREST);
    scaled.copyTo(image(cv::Rect(left(i), kTop, size.width, size.height)));
    cv::rectangle(image, cv::Rect(left(i) - 1, kTop - 1, size.width + 2, size.height + 2),
                  colors::kFrame);
  }
  return image;
}

}  // namespace fusion_slam
