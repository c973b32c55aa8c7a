#include "libs/evaluation/plot/map_plot.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

int pixels_of(const cv::Mat& image, const cv::Rect& area, const cv::Vec3b& colour) {
  int n = 0;
  for (int y = area.y; y < area.y + area.height; ++y)
    for (int x = area.x; x < area.x + area.width; ++x) n += image.at<cv::Vec3b>(y, x) == colour;
  return n;
}

TEST(MapPlot, EachPanelShowsItsCells) {
  // One row: reference occupied, free, occupied (missed), free; estimate has a false cell at 3.
  MapRaster reference, estimate;
  reference.resolution_m = estimate.resolution_m = 0.1;
  reference.width = estimate.width = 8;
  reference.height = estimate.height = 4;
  reference.probability.assign(32, 1);
  estimate.probability.assign(32, 1);
  reference.provenance = estimate.provenance = std::vector<std::uint8_t>(32, 0);
  std::vector<std::uint8_t> classes(32, 0);
  reference.probability[0] = estimate.probability[0] = 255;
  reference.probability[3] = 255;
  classes[0] = 1;
  classes[3] = 3;
  estimate.probability[31] = 255;
  const auto resampled = resample(reference, estimate, SE2{});
  ASSERT_TRUE(resampled);
  const MapScore score = score_map(reference, classes, *resampled, 1);
  const cv::Mat image = draw_map_plot({reference, classes, *resampled, score, 1, "t", "s"});
  EXPECT_EQ(image.cols, 1500);
  const int cell = 473 / 8;  // pixels, about
  const auto panel = [&](int i) { return cv::Rect(20 + i * 493, 92, 473, 473 / 2); };
  EXPECT_NEAR(pixels_of(image, panel(0), {70, 70, 70}), cell * cell, cell * 3);   // wall
  EXPECT_NEAR(pixels_of(image, panel(0), {0, 94, 213}), cell * cell, cell * 3);   // chair
  EXPECT_NEAR(pixels_of(image, panel(1), {0, 0, 0}), 2 * cell * cell, cell * 6);  // occupied
  EXPECT_NEAR(pixels_of(image, panel(2), {60, 60, 60}), cell * cell, cell * 3);   // right
  EXPECT_NEAR(pixels_of(image, panel(2), {178, 114, 0}), cell * cell, cell * 3);  // missed
  EXPECT_NEAR(pixels_of(image, panel(2), {0, 94, 213}), cell * cell, cell * 3);   // false
}

}  // namespace
}  // namespace fusion_slam
