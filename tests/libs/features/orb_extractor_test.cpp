#include "libs/features/orb_extractor.hpp"

#include <array>
#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "libs/features/matching.hpp"

namespace fusion_slam {
namespace {

// Blurred noise: corners everywhere.
cv::Mat textured(int width, int height) {
  std::mt19937 random(17);
  cv::Mat image(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.at<std::uint8_t>(y, x) = random() % 256;
  cv::GaussianBlur(image, image, cv::Size(0, 0), 2.0);
  cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  return image;
}

TEST(OrbExtractor, FillsItsQuotaEvenly) {
  const FeatureSet set = OrbExtractor().extract(textured(640, 480));
  EXPECT_NEAR(static_cast<double>(set.size()), 1000.0, 10.0);
  ASSERT_EQ(set.features.size(), set.descriptors.size());
  std::array<int, 16> parts{};
  for (const Feature& f : set.features) {
    ASSERT_TRUE(f.u_px >= 0 && f.u_px < 640 && f.v_px >= 0 && f.v_px < 480);
    ++parts[static_cast<int>(f.v_px / 120) * 4 + static_cast<int>(f.u_px / 160)];
  }
  for (const int n : parts) EXPECT_GT(n, 30);  // 62 when even
  EXPECT_EQ(set.features.back().octave, 7);
}

TEST(OrbExtractor, TextureInOneCornerDoesNotStarveTheRest) {
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(128));
  textured(200, 200).copyTo(image(cv::Rect(20, 20, 200, 200)));
  cv::rectangle(image, cv::Rect(500, 350, 40, 40), cv::Scalar(145), cv::FILLED);  // faint
  const FeatureSet set = OrbExtractor().extract(image);
  int faint = 0;
  for (const Feature& f : set.features) faint += f.u_px > 480 && f.v_px > 330 ? 1 : 0;
  EXPECT_GE(faint, 4);
}

TEST(OrbExtractor, SameImageSameFeatures) {
  const cv::Mat image = textured(320, 240);
  const FeatureSet a = OrbExtractor().extract(image);
  const FeatureSet b = OrbExtractor().extract(image);
  EXPECT_EQ(a.descriptors, b.descriptors);
}

TEST(OrbExtractor, NothingToSeeNothingFound) {
  EXPECT_TRUE(OrbExtractor().extract(cv::Mat(480, 640, CV_8UC1, cv::Scalar(90))).empty());
  EXPECT_TRUE(OrbExtractor().extract(textured(20, 20)).empty());
}

// Turned by 30 degrees and shrunk by 1.2 ^ 2, the same corners are found two octaves higher,
// turned, without a shift.
TEST(OrbExtractor, FollowsRotationAndScale) {
  const cv::Mat image = textured(640, 480);
  const double scale = 1.0 / 1.44;
  const cv::Mat A = cv::getRotationMatrix2D(cv::Point2f(319.5F, 239.5F), -30.0, scale);
  cv::Mat turned;
  cv::warpAffine(image, turned, A, image.size(), cv::INTER_AREA, cv::BORDER_REFLECT);
  const FeatureSet a = OrbExtractor().extract(image);
  const FeatureSet b = OrbExtractor().extract(turned);
  int good = 0;
  cv::Vec2d shift(0, 0);
  double octaves = 0.0;
  double turn = 0.0;
  for (const Match& m : match_mutual(a.descriptors, b.descriptors)) {
    const Feature& from = a.features[m.a];
    const Feature& to = b.features[m.b];
    const double u =
        A.at<double>(0, 0) * from.u_px + A.at<double>(0, 1) * from.v_px + A.at<double>(0, 2);
    const double v =
        A.at<double>(1, 0) * from.u_px + A.at<double>(1, 1) * from.v_px + A.at<double>(1, 2);
    if (std::hypot(to.u_px - u, to.v_px - v) > 4.0) continue;
    ++good;
    shift += cv::Vec2d(to.u_px - u, to.v_px - v);
    octaves += to.octave - from.octave;
    turn += std::remainder(to.angle_rad - from.angle_rad, 2.0 * M_PI);
  }
  ASSERT_GT(good, 60);
  EXPECT_NEAR(shift[0] / good, 0.0, 0.25);
  EXPECT_NEAR(shift[1] / good, 0.0, 0.25);
  EXPECT_NEAR(octaves / good, -2.0, 0.7);
  EXPECT_NEAR(turn / good, M_PI / 6.0, 0.05);
}

}  // namespace
}  // namespace fusion_slam
