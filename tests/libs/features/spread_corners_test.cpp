#include "libs/features/spread_corners.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace fusion_slam {
namespace {

// Texture whose contrast falls from left to right: strong corners, faint ones, none.
cv::Mat fading(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  cv::Mat image(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.at<std::uint8_t>(y, x) = random() % 256;
  cv::GaussianBlur(image, image, cv::Size(0, 0), 1.5);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int grey = image.at<std::uint8_t>(y, x) - 128;
      image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(128 + grey * (width - x) / width);
    }
  return image;
}

bool stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  if (a.response != b.response) return a.response > b.response;
  if (a.pt.y != b.pt.y) return a.pt.y < b.pt.y;
  return a.pt.x < b.pt.x;
}

// Slow and obvious: every corner at the low threshold, each cell's sorted, round by round.
std::vector<cv::KeyPoint> from_all_corners(const cv::Mat& image, int quota, int usual, int low) {
  const double cell_px = std::max(8.0, std::sqrt(image.size().area() * 4.0 / quota));
  std::vector<cv::KeyPoint> all;
  cv::FAST(image, all, low, true);
  std::map<std::pair<int, int>, std::vector<cv::KeyPoint>> cells;
  for (const cv::KeyPoint& corner : all)
    cells[{static_cast<int>(corner.pt.y / cell_px), static_cast<int>(corner.pt.x / cell_px)}]
        .push_back(corner);
  for (auto& [index, cell] : cells) std::sort(cell.begin(), cell.end(), stronger);
  std::vector<cv::KeyPoint> kept;
  for (std::size_t k = 0; k < all.size() && kept.size() < static_cast<std::size_t>(quota); ++k) {
    std::vector<cv::KeyPoint> round;
    for (const auto& [index, cell] : cells)
      if (k < cell.size() && (k == 0 || cell[k].response >= static_cast<float>(usual)))
        round.push_back(cell[k]);
    if (round.size() > quota - kept.size()) {
      std::sort(round.begin(), round.end(), stronger);
      round.resize(quota - kept.size());
    }
    kept.insert(kept.end(), round.begin(), round.end());
  }
  return kept;
}

void expect_same(const std::vector<cv::KeyPoint>& a, const std::vector<cv::KeyPoint>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].pt, b[i].pt);
    EXPECT_EQ(a[i].response, b[i].response);
  }
}

TEST(SpreadCorners, AreThoseOfAllCornersAtTheLowThreshold) {
  for (const cv::Size& size : {cv::Size(320, 240), cv::Size(97, 61), cv::Size(33, 200)})
    for (const int quota : {20, 60, 217}) {
      const cv::Mat image = fading(size.width, size.height, 3U + static_cast<unsigned>(quota));
      const auto kept = spread_corners(image, quota, 20, 5);
      EXPECT_FALSE(kept.empty());
      expect_same(kept, from_all_corners(image, quota, 20, 5));
    }
}

TEST(SpreadCorners, FaintOnesOnlyWhereNothingElseIs) {
  const cv::Mat image = fading(320, 240, 1);
  int faint = 0;
  for (const cv::KeyPoint& corner : spread_corners(image, 100, 20, 5))
    faint += corner.response < 20.0F ? 1 : 0;
  EXPECT_GT(faint, 0);
  for (const cv::KeyPoint& corner : spread_corners(image, 100, 20, 20))
    EXPECT_GE(corner.response, 20.0F);
}

TEST(SpreadCorners, TooSmallForARing) {
  EXPECT_TRUE(spread_corners(cv::Mat(6, 6, CV_8UC1, cv::Scalar(9)), 10, 20, 5).empty());
}

}  // namespace
}  // namespace fusion_slam
