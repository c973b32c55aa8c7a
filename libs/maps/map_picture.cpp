#include "libs/maps/map_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace fusion_slam {
namespace {

// Blue, green, red. The last six are of Okabe & Ito's palette.
const cv::Vec3b kUnknownGrey(205, 205, 205);
const cv::Vec3b kFreeWhite(252, 252, 252);
const cv::Vec3b kBlack(0, 0, 0);
const cv::Vec3b kLidarBlue(178, 114, 0);
const cv::Vec3b kCameraVermilion(0, 94, 213);
const cv::Vec3b kConflictPurple(167, 121, 204);
const cv::Vec3b kWayGreen(115, 158, 0);

constexpr int kMinPixels = 900;     // of the map's longer side
constexpr int kWayMarginCells = 2;  // around the way, for its marks
constexpr int kMaxCellPixels = 8;   // a cell is a square of at most this
constexpr int kMargin = 24;
constexpr int kLegendHeight = 84;
constexpr int kMinWidth = 900;  // the legend's
constexpr int kMaxSide = 8192;  // cells of a picture, with the way: 200 MB before compression

cv::Scalar scalar(const cv::Vec3b& c) { return {double(c[0]), double(c[1]), double(c[2])}; }

// Whole cells around the raster so that the way fits in; never more than the raster's longer side
// each way.
struct Canvas {
  int left = 0;
  int right = 0;
  int below = 0;
  int above = 0;
  int longer = 0;  // side of all that, cells
  int cell_pixels = 1;

  Canvas(const MapRaster& raster, const std::vector<Eigen::Vector2d>& way_m) {
    const int most = std::max(raster.width, raster.height);
    const auto cells = [&](double metres) {
      return static_cast<int>(
          std::clamp(std::ceil(metres / raster.resolution_m) + kWayMarginCells, 0.0, double(most)));
    };
    const double top_m = raster.origin_y_m + raster.height * raster.resolution_m;
    const double right_m = raster.origin_x_m + raster.width * raster.resolution_m;
    for (const Eigen::Vector2d& p : way_m) {
      left = std::max(left, cells(raster.origin_x_m - p.x()));
      right = std::max(right, cells(p.x() - right_m));
      below = std::max(below, cells(raster.origin_y_m - p.y()));
      above = std::max(above, cells(p.y() - top_m));
    }
    longer = std::max(left + raster.width + right, below + raster.height + above);
    cell_pixels = std::clamp((kMinPixels + longer - 1) / longer, 1, kMaxCellPixels);
  }
};

cv::Vec3b colour(std::uint8_t cell, std::uint8_t provenance, bool by_sensor) {
  const CellState state = state_of_cell(cell);
  if (state == CellState::kUnoccupied) return kFreeWhite;
  if (state == CellState::kUnknown) return kUnknownGrey;
  if (!by_sensor) return kBlack;
  switch (static_cast<Provenance>(provenance)) {
    case Provenance::kLidar:
      return kLidarBlue;
    case Provenance::kCamera:
      return kCameraVermilion;
    case Provenance::kConflict:
      return kConflictPurple;
    case Provenance::kBoth:
    case Provenance::kNone:
      break;
  }
  return kBlack;
}

// What of two cells is drawn where there is room for one.
int importance(std::uint8_t cell) {
  const CellState state = state_of_cell(cell);
  return state == CellState::kOccupied ? 2 : (state == CellState::kUnoccupied ? 1 : 0);
}

// k x k cells as one.
MapRaster coarser(const MapRaster& raster, int k) {
  MapRaster coarse;
  coarse.resolution_m = raster.resolution_m * k;
  coarse.origin_x_m = raster.origin_x_m;
  coarse.origin_y_m = raster.origin_y_m;
  coarse.width = (raster.width - 1) / k + 1;
  coarse.height = (raster.height - 1) / k + 1;
  coarse.probability.assign(coarse.index(0, coarse.height), kUnknownCell);
  coarse.provenance.assign(coarse.probability.size(), 0);
  for (int row = 0; row < raster.height; ++row) {
    for (int column = 0; column < raster.width; ++column) {
      const std::size_t from = raster.index(column, row);
      const std::size_t to = coarse.index(column / k, row / k);
      if (importance(raster.probability[from]) <= importance(coarse.probability[to])) continue;
      coarse.probability[to] = raster.probability[from];
      coarse.provenance[to] = raster.provenance[from];
    }
  }
  return coarse;
}

bool holds_both_sensors(const MapRaster& raster) {
  bool lidar = false;
  bool camera = false;
  for (const std::uint8_t p : raster.provenance) {
    const auto provenance = static_cast<Provenance>(p);
    const bool both = provenance == Provenance::kBoth || provenance == Provenance::kConflict;
    lidar = lidar || both || provenance == Provenance::kLidar;
    camera = camera || both || provenance == Provenance::kCamera;
  }
  return lidar && camera;
}

// 1, 2 or 5 times a power of ten, about a fifth of the width.
double round_length_m(double width_m) {
  const double wanted = width_m / 5.0;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  for (const double step : {5.0, 2.0})
    if (step * decade <= wanted) return step * decade;
  return decade;
}

void text(cv::Mat& picture, const std::string& words, cv::Point at) {
  cv::putText(picture, words, at, cv::FONT_HERSHEY_SIMPLEX, 0.5, scalar(kBlack), 1, cv::LINE_AA);
}

void draw_mark(cv::Mat& picture, cv::Point at, bool start) {
  const cv::Scalar white = scalar({255, 255, 255});
  if (start) {
    cv::circle(picture, at, 8, white, cv::FILLED, cv::LINE_AA);
    cv::circle(picture, at, 6, scalar(kWayGreen), cv::FILLED, cv::LINE_AA);
  } else {
    cv::rectangle(picture, at - cv::Point(8, 8), at + cv::Point(8, 8), white, cv::FILLED);
    cv::rectangle(picture, at - cv::Point(6, 6), at + cv::Point(6, 6), scalar(kWayGreen),
                  cv::FILLED);
  }
}

void draw_way(cv::Mat& picture, const std::vector<cv::Point>& way) {
  if (way.empty()) return;
  cv::polylines(picture, way, false, scalar({255, 255, 255}), 4, cv::LINE_AA);
  cv::polylines(picture, way, false, scalar(kWayGreen), 2, cv::LINE_AA);
  draw_mark(picture, way.front(), true);
  draw_mark(picture, way.back(), false);
}

void draw_legend(cv::Mat& picture, int top, double metres_per_pixel, bool by_sensor, bool way) {
  const int y = top + 26;
  const double bar_m = round_length_m(picture.cols * metres_per_pixel);
  const int bar_px = static_cast<int>(std::lround(bar_m / metres_per_pixel));
  cv::rectangle(picture, {kMargin, y - 8}, {kMargin + bar_px, y - 3}, scalar(kBlack), cv::FILLED);
  char length[32];
  std::snprintf(length, sizeof length, "%g m", bar_m);
  text(picture, length, {kMargin + bar_px + 8, y});

  int x = kMargin;
  const int line = top + 64;
  const auto box = [&](const cv::Vec3b& fill, const std::string& words) {
    cv::rectangle(picture, {x, line - 13}, {x + 15, line + 2}, scalar(fill), cv::FILLED);
    cv::rectangle(picture, {x, line - 13}, {x + 15, line + 2}, scalar(kBlack), 1);
    text(picture, words, {x + 22, line});
    x += 40 + 10 * static_cast<int>(words.size());
  };
  box(kFreeWhite, "free");
  box(kUnknownGrey, "unknown");
  if (by_sensor) {
    box(kBlack, "both sensors");
    box(kLidarBlue, "LiDAR only");
    box(kCameraVermilion, "camera only");
    box(kConflictPurple, "conflict");
  } else {
    box(kBlack, "occupied");
  }
  if (!way) return;
  draw_mark(picture, {x + 8, line - 5}, true);
  text(picture, "start", {x + 22, line});
  draw_mark(picture, {x + 90, line - 5}, false);
  text(picture, "end", {x + 104, line});
}

}  // namespace

std::string map_png_bytes(const MapRaster& raster, const std::vector<Eigen::Vector2d>& way_m) {
  const Canvas canvas(raster, way_m);
  if (canvas.longer > kMaxSide)
    return map_png_bytes(coarser(raster, (canvas.longer - 1) / kMaxSide + 1), way_m);
  const int s = canvas.cell_pixels;
  const int map_width = (canvas.left + raster.width + canvas.right) * s;
  const int map_height = (canvas.above + raster.height + canvas.below) * s;
  cv::Mat picture(map_height + 2 * kMargin + kLegendHeight,
                  std::max(kMinWidth, map_width + 2 * kMargin), CV_8UC3, scalar({255, 255, 255}));
  cv::Mat map = picture(cv::Rect((picture.cols - map_width) / 2, kMargin, map_width, map_height));
  map.setTo(scalar(kUnknownGrey));

  const bool by_sensor = holds_both_sensors(raster);
  for (int row = 0; row < raster.height; ++row) {
    for (int column = 0; column < raster.width; ++column) {
      const std::size_t i = raster.index(column, row);
      const cv::Vec3b c = colour(raster.probability[i], raster.provenance[i], by_sensor);
      const int y = (canvas.above + raster.height - 1 - row) * s;
      map(cv::Rect((canvas.left + column) * s, y, s, s)).setTo(scalar(c));
    }
  }
  std::vector<cv::Point> way;
  const double pixels_per_m = s / raster.resolution_m;
  for (const Eigen::Vector2d& p : way_m) {
    const double x = (p.x() - raster.origin_x_m) * pixels_per_m + canvas.left * s;
    const double y =
        (canvas.above + raster.height) * s - (p.y() - raster.origin_y_m) * pixels_per_m;
    const cv::Point pixel(static_cast<int>(std::lround(std::clamp(x, -1e4, 1e5))),
                          static_cast<int>(std::lround(std::clamp(y, -1e4, 1e5))));
    if (way.empty() || way.back() != pixel) way.push_back(pixel);
  }
  draw_way(map, way);
  draw_legend(picture, map_height + 2 * kMargin, 1.0 / pixels_per_m, by_sensor, !way.empty());

  std::vector<unsigned char> png;
  cv::imencode(".png", picture, png);
  return {png.begin(), png.end()};
}

}  // namespace fusion_slam
