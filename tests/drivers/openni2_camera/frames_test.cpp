// Images, times and pairs: no device.
#include <algorithm>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/openni2_camera/device_clock.hpp"
#include "drivers/openni2_camera/frame_pairer.hpp"
#include "drivers/openni2_camera/latest.hpp"
#include "drivers/openni2_camera/pixel_formats.hpp"
#include "libs/camera/image_codec.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

RawImage raw(PixelFormat format, int width_px, int height_px,
             const std::vector<std::uint8_t>& bytes) {
  RawImage image;
  image.format = format;
  image.width_px = width_px;
  image.height_px = height_px;
  image.bytes = bytes.data();
  image.size_bytes = bytes.size();
  return image;
}

TEST(PixelFormats, ColoursComeInOurOrder) {
  std::string why;
  const std::vector<std::uint8_t> rgb = {255, 0, 0, 0, 255, 0};
  const auto a = read_image(raw(PixelFormat::kRgb, 2, 1, rgb), {2, 1}, &why);
  ASSERT_TRUE(a);
  EXPECT_EQ(a->at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 255));
  EXPECT_EQ(a->at<cv::Vec3b>(0, 1), cv::Vec3b(0, 255, 0));
  // BT.601 red: Y 82, U 90, V 240; two pixels share U and V.
  const std::vector<std::uint8_t> uyvy = {90, 82, 240, 82};
  const std::vector<std::uint8_t> yuyv = {82, 90, 82, 240};
  for (const auto& b : {read_image(raw(PixelFormat::kUyvy, 2, 1, uyvy), {2, 1}, &why),
                        read_image(raw(PixelFormat::kYuyv, 2, 1, yuyv), {2, 1}, &why)}) {
    ASSERT_TRUE(b);
    EXPECT_GT(b->at<cv::Vec3b>(0, 1)[2], 245);
    EXPECT_LT(b->at<cv::Vec3b>(0, 1)[0], 10);
  }
  const auto grey = read_image(raw(PixelFormat::kGrey, 2, 1, {{7, 9}}), {2, 1}, &why);
  EXPECT_EQ(grey->at<cv::Vec3b>(0, 1), cv::Vec3b(9, 9, 9));
}

TEST(PixelFormats, DepthIsInMillimetresAndRowsMayHaveGaps) {
  std::string why;
  const std::vector<std::uint8_t> bytes = {0xE8, 0x03, 0xFF, 0xFF, 0x0E, 0x00, 0xFF, 0xFF};
  RawImage image = raw(PixelFormat::kDepthMm, 1, 2, bytes);
  image.stride_bytes = 4;
  const auto mm = read_image(image, {1, 2}, &why);
  ASSERT_TRUE(mm);
  EXPECT_EQ(mm->at<std::uint16_t>(0, 0), 1000);
  EXPECT_EQ(mm->at<std::uint16_t>(1, 0), 14);
  image.format = PixelFormat::kDepth100um;
  const auto rounded = read_image(image, {1, 2}, &why);
  EXPECT_EQ(rounded->at<std::uint16_t>(0, 0), 100);
  EXPECT_EQ(rounded->at<std::uint16_t>(1, 0), 1);
}

TEST(PixelFormats, WhatDoesNotFitIsRefusedWithAReason) {
  std::string why;
  const std::vector<std::uint8_t> bytes(12);
  EXPECT_FALSE(read_image(raw(PixelFormat::kRgb, 2, 2, bytes), {4, 2}, &why));
  EXPECT_THAT(why, HasSubstr("2 x 2 and not 4 x 2"));
  EXPECT_FALSE(read_image(raw(PixelFormat::kRgb, 4, 2, bytes), {4, 2}, &why));
  EXPECT_THAT(why, HasSubstr("12 bytes instead of 24"));
  RawImage narrow = raw(PixelFormat::kRgb, 2, 2, bytes);
  narrow.stride_bytes = -3;
  EXPECT_FALSE(read_image(narrow, {2, 2}, &why));
  EXPECT_FALSE(read_image(raw(PixelFormat::kJpeg, 2, 2, bytes), {2, 2}, &why));
  EXPECT_THAT(why, HasSubstr("JPEG"));
  const Bytes jpeg = encode_jpeg(cv::Mat(2, 2, CV_8UC3, cv::Scalar(1, 2, 250)));
  const auto good = read_image(raw(PixelFormat::kJpeg, 2, 2, jpeg), {2, 2}, &why);
  ASSERT_TRUE(good);
  EXPECT_GT(good->at<cv::Vec3b>(1, 1)[2], 240);
}

TEST(DeviceClock, FindsDriftAndOffsetUnderJitter) {
  std::mt19937 random(3);
  std::exponential_distribution<double> late_us(1.0 / 8000.0);
  for (const double ppm : {-80.0, 0.0, 150.0}) {
    DeviceClock clock;
    double worst_us = 0.0;
    for (int i = 1; i < 30 * 90; ++i) {
      const double taken_us = 1e9 + i * 33'333.0;  // host
      const double stamp_us = 5e5 + i * 33'333.0 * (1.0 - 1e-6 * ppm);
      const double arrival_us = taken_us + 2000.0 + late_us(random);
      const auto found =
          clock.add(static_cast<std::int64_t>(stamp_us), static_cast<std::int64_t>(arrival_us));
      EXPECT_LE(found, static_cast<std::int64_t>(arrival_us));
      if (i > 30 * 15)  // the shortest delay, 2 ms, is no clock's to see
        worst_us = std::max(worst_us, std::abs(static_cast<double>(found) - taken_us - 2000.0));
    }
    EXPECT_LT(worst_us, 1500.0) << ppm;
    EXPECT_NEAR(clock.drift_ppm(), ppm, 25.0);
    EXPECT_EQ(clock.restarts(), 0);
  }
}

TEST(DeviceClock, TheLineLiesBelowAllArrivals) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> late_us(0.0, 30'000.0);
  DeviceClock clock;
  std::int64_t before = 0;
  for (int i = 1; i < 3000; ++i) {
    const std::int64_t stamp = 1'000'000 + i * 33'333LL;
    const auto arrival = static_cast<std::int64_t>(7e8 + i * 33'333.0 + late_us(random));
    const std::int64_t found = clock.add(stamp, arrival);
    EXPECT_LE(found, arrival);
    if (i > 300) {
      EXPECT_GT(found, before);
    }
    before = found;
  }
}

TEST(DeviceClock, JumpsAreNoticedAndNoStampMeansArrival) {
  DeviceClock clock;
  for (int i = 1; i <= 60; ++i) clock.add(i * 33'333, 5'000'000 + i * 33'333);
  EXPECT_EQ(clock.add(1, 7'100'000), 7'100'000);  // its clock began anew
  EXPECT_EQ(clock.restarts(), 1);
  EXPECT_EQ(clock.add(33'334, 7'140'000), 7'133'333);     // 6.7 ms later than the one before
  EXPECT_EQ(clock.add(9'000'000, 7'166'666), 7'166'666);  // ahead
  EXPECT_EQ(clock.restarts(), 2);
  EXPECT_EQ(clock.add(0, 123), 123);
  EXPECT_EQ(clock.restarts(), 2);
}

// What the pairer does, said slowly: each colour image with the nearest depth image of all, when
// that is within half a period.
TEST(FramePairer, PairsAsLookingAtAllImagesAtOnce) {
  std::mt19937 random(11);
  for (int run = 0; run < 20; ++run) {
    std::uniform_int_distribution<int> jitter(-4000, 4000);
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    const int phase_us = 1000 * (run % 7);
    std::vector<std::int64_t> colour, depth;
    for (int i = 1; i < 200; ++i) {
      if (chance(random) < 0.9) colour.push_back(i * 33'333 + jitter(random));
      if (chance(random) < 0.9) depth.push_back(i * 33'333 + phase_us + jitter(random));
    }
    std::vector<std::pair<std::int64_t, std::int64_t>> expected, found;
    for (const auto c : colour) {
      const auto d = *std::min_element(depth.begin(), depth.end(), [c](auto a, auto b) {
        return std::abs(a - c) < std::abs(b - c);
      });
      if (std::abs(d - c) <= 16'666) expected.emplace_back(c, d);
    }
    FramePairer pairer(1.0 / 30.0);
    for (std::size_t i = 0, j = 0; i < colour.size() || j < depth.size();) {
      // Either may be up to 100 ms late on its way.
      const std::int64_t ahead_us = static_cast<std::int64_t>(2e5 * (chance(random) - 0.5));
      const bool take_colour =
          j == depth.size() || (i < colour.size() && colour[i] < depth[j] + ahead_us);
      const auto pair = take_colour ? pairer.add_colour({colour[i], cv::Mat(), 0})
                                    : pairer.add_depth({depth[j], cv::Mat(), 0});
      ++(take_colour ? i : j);
      if (pair) found.emplace_back(pair->colour.utime_us, pair->depth.utime_us);
    }
    EXPECT_EQ(found, expected) << "phase " << phase_us;
    EXPECT_EQ(pairer.counters().pairs, static_cast<std::int64_t>(found.size()));
  }
}

TEST(FramePairer, InterleavedStreamsLoseNothing) {
  FramePairer pairer(1.0 / 30.0);
  int pairs = 0;
  for (int i = 1; i <= 100; ++i) {
    pairs += pairer.add_colour({i * 33'333LL, cv::Mat(), 0}).has_value();
    const auto pair = pairer.add_depth({i * 33'333LL + 9000, cv::Mat(), 0});
    pairs += pair.has_value();
    if (pair) {
      EXPECT_EQ(pair->error_us(), 9000);
    }
  }
  EXPECT_EQ(pairs, 100);
  EXPECT_EQ(pairer.counters().colour_alone + pairer.counters().depth_alone, 0);
}

TEST(FramePairer, AStreamThatStopsHoldsLittle) {
  FramePairer pairer(1.0 / 30.0);
  for (int i = 1; i <= 100; ++i) EXPECT_FALSE(pairer.add_colour({i * 33'333LL, cv::Mat(), 0}));
  EXPECT_GE(pairer.counters().colour_alone, 90);
  EXPECT_FALSE(pairer.add_colour({1, cv::Mat(), 0}));  // backwards
  EXPECT_TRUE(pairer.add_depth({100 * 33'333LL, cv::Mat(), 0}));
}

TEST(Latest, KeepsTheNewestAndEnds) {
  Latest<int> latest;
  latest.put(1);
  latest.put(2);
  EXPECT_EQ(latest.take(), 2);
  EXPECT_EQ(latest.replaced(), 1);
  latest.close();
  EXPECT_FALSE(latest.take().has_value());
}

}  // namespace
}  // namespace fusion_slam
