#include "libs/maps/map_picture.hpp"

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/libs/maps/test_files.hpp"

namespace fusion_slam {
namespace {

cv::Mat decode(const std::string& png) {
  const std::vector<unsigned char> bytes(png.begin(), png.end());
  return cv::imdecode(bytes, cv::IMREAD_COLOR);
}

int count(const cv::Mat& picture, const cv::Vec3b& colour) {
  int n = 0;
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) n += picture.at<cv::Vec3b>(y, x) == colour ? 1 : 0;
  return n;
}

MapRaster room(int width, int height) {
  MapRaster raster;
  raster.width = width;
  raster.height = height;
  raster.probability.assign(static_cast<std::size_t>(width * height), cell_from_probability(0.1));
  raster.provenance.assign(raster.probability.size(), 1);
  for (int x = 0; x < width; ++x)
    raster.probability[raster.index(x, 0)] = cell_from_probability(0.9);
  return raster;
}

TEST(MapPicture, SameInputSameBytes) {
  const std::vector<Eigen::Vector2d> way{{0.0, 0.2}, {1.0, 0.5}, {2.0, 3.0}};
  EXPECT_EQ(map_png_bytes(room(80, 90), way), map_png_bytes(room(80, 90), way));
}

TEST(MapPicture, WallAtLowYIsAtTheBottom) {
  const cv::Mat picture = decode(map_png_bytes(room(100, 100), {}));
  ASSERT_FALSE(picture.empty());
  EXPECT_GE(picture.cols, 900);
  // 8 pixels a cell, 24 of margin above: the first row is free, the 100th occupied.
  EXPECT_EQ(picture.at<cv::Vec3b>(24 + 4, picture.cols / 2), cv::Vec3b(252, 252, 252));
  EXPECT_EQ(picture.at<cv::Vec3b>(24 + 99 * 8 + 4, picture.cols / 2), cv::Vec3b(0, 0, 0));
}

TEST(MapPicture, ColoursBySensorWhenThereAreTwo) {
  MapRaster raster = room(100, 100);
  const cv::Vec3b lidar(178, 114, 0);
  const cv::Vec3b camera(0, 94, 213);
  EXPECT_EQ(count(decode(map_png_bytes(raster, {})), lidar), 0);
  for (int x = 50; x < 100; ++x) raster.provenance[raster.index(x, 0)] = 2;
  const cv::Mat picture = decode(map_png_bytes(raster, {}));
  EXPECT_GT(count(picture, lidar), 50 * 64);
  EXPECT_GT(count(picture, camera), 50 * 64);
}

TEST(MapPicture, TheWayIsOnItEvenOutsideTheKnownCells) {
  const cv::Vec3b green(115, 158, 0);
  const cv::Mat without = decode(map_png_bytes(room(60, 60), {}));
  EXPECT_EQ(count(without, green), 0);
  const cv::Mat inside = decode(map_png_bytes(room(60, 60), {{0.5, 0.5}, {2.5, 2.5}}));
  EXPECT_GT(count(inside, green), 300);
  const cv::Mat outside = decode(map_png_bytes(room(60, 60), {{0.5, 0.5}, {-2.0, -2.0}}));
  EXPECT_GT(count(outside, green), 300);
  const cv::Mat absurd = decode(map_png_bytes(room(60, 60), {{0.5, 0.5}, {1e30, -1e30}}));
  EXPECT_FALSE(absurd.empty());
}

TEST(MapPicture, OneCellIsEnough) { EXPECT_FALSE(decode(map_png_bytes(room(1, 1), {})).empty()); }

TEST(MapPicture, AMapTooLargeToDrawCellByCellIsDrawnCoarser) {
  MapRaster raster = room(3'000'000, 2);  // 150 km: no PNG is that wide
  raster.probability[raster.index(0, 1)] = kUnknownCell;
  const cv::Mat picture = decode(map_png_bytes(raster, {{1.0, 0.05}, {-1e5, 1e5}}));
  ASSERT_FALSE(picture.empty());
  EXPECT_LE(std::max(picture.cols, picture.rows), 8192 + 132);
  EXPECT_GT(count(picture, cv::Vec3b(0, 0, 0)), 2000);  // the wall outweighs the free cells above
}

}  // namespace
}  // namespace fusion_slam
