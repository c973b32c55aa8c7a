#include "libs/camera_messages/images.hpp"

#include <random>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace fusion_slam {
namespace {

using bot_core::image_t;
using bot_core::images_t;

RgbdFrame make_frame(int width, int height, bool noise) {
  std::mt19937 random(1);
  RgbdFrame frame{123456, cv::Mat(height, width, CV_8UC3), cv::Mat(height, width, CV_16UC1)};
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      frame.depth_mm.at<std::uint16_t>(v, u) =
          static_cast<std::uint16_t>(500 + v + (noise ? random() % 8 : 0));
      const auto grey = static_cast<std::uint8_t>(noise ? random() : 100 + u % 50);
      frame.colour_bgr.at<cv::Vec3b>(v, u) = {grey, static_cast<std::uint8_t>(255 - grey), 40};
    }
  return frame;
}

TEST(Images, FrameComesBack) {
  const RgbdFrame frame = make_frame(64, 48, false);
  std::string why;
  const auto back = from_message(to_message(frame), &why);
  ASSERT_TRUE(back) << why;
  EXPECT_EQ(back->utime_us, 123456);
  EXPECT_EQ(cv::norm(back->depth_mm, frame.depth_mm, cv::NORM_INF), 0.0);
  EXPECT_LT(cv::norm(back->colour_bgr, frame.colour_bgr, cv::NORM_INF), 40.0);
}

TEST(Images, WireFieldsAreWhatLibbotExpects) {
  const images_t m = to_message(make_frame(64, 48, false));
  ASSERT_EQ(m.n_images, 2);
  EXPECT_EQ(m.image_types[0], +images_t::LEFT);
  EXPECT_EQ(m.image_types[1], +images_t::DEPTH_MM_ZIPPED);
  EXPECT_EQ(m.images[0].pixelformat, +image_t::PIXEL_FORMAT_MJPEG);
  EXPECT_EQ(m.images[0].width, 64);
  EXPECT_EQ(m.images[1].row_stride, 128);
  EXPECT_EQ(m.images[1].size, static_cast<int>(m.images[1].data.size()));
}

TEST(Images, PackedFrameComesBack) {
  const RgbdFrame frame = make_frame(64, 48, true);
  const images_t m = to_message(frame, kJpegQuality, ImageCoding::kPacked);
  EXPECT_EQ(m.image_types[0], +images_t::LEFT);
  EXPECT_EQ(m.image_types[1], kDepthPacked);
  EXPECT_EQ(depth_image(m), &m.images[1]);
  std::string why;
  const auto back = from_message(m, &why), plain = from_message(to_message(frame), &why);
  ASSERT_TRUE(back && plain) << why;
  EXPECT_EQ(cv::norm(back->depth_mm, frame.depth_mm, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(back->colour_bgr, plain->colour_bgr, cv::NORM_INF), 0.0);
  EXPECT_LT(m.images[0].size, to_message(frame).images[0].size);
  images_t bad = m;
  bad.images[1].data.resize(bad.images[1].data.size() / 2);
  EXPECT_FALSE(from_message(bad, &why));
  EXPECT_EQ(why, "packed depth is damaged or of another size");
}

TEST(Images, WorstFrameStaysBelowTheLimit) {
  const images_t m = to_message(make_frame(640, 480, true));  // white noise
  EXPECT_LE(m.images[0].data.size() + m.images[1].data.size(), kMaxFrameBytes);
}

TEST(Images, GivenJpegIsSentAsItIs) {
  const RgbdFrame frame = make_frame(64, 48, false);
  const Bytes jpeg = encode_jpeg(frame.colour_bgr, 50);
  EXPECT_EQ(to_message(1, jpeg, frame.depth_mm).images[0].data, jpeg);
}

images_t raw_message(int format, int bytes_per_pixel, int stride) {
  images_t m{};
  m.n_images = 2;
  m.image_types = {images_t::DEPTH_MM, images_t::LEFT};
  m.images.resize(2);
  for (image_t& image : m.images) {
    image.width = 4;
    image.height = 3;
  }
  m.images[0].data.assign(24, 1);
  m.images[1].pixelformat = format;
  m.images[1].row_stride = stride;
  m.images[1].data.assign(static_cast<std::size_t>(stride * 2 + 4 * bytes_per_pixel), 0);
  for (std::size_t i = 0; i < m.images[1].data.size(); ++i)
    m.images[1].data[i] = static_cast<std::uint8_t>(i);
  return m;
}

TEST(Images, RawColourWithPaddedRowsAndRawDepth) {
  std::string why;
  const auto rgb = from_message(raw_message(image_t::PIXEL_FORMAT_RGB, 3, 16), &why);
  ASSERT_TRUE(rgb) << why;
  EXPECT_EQ(rgb->colour_bgr.at<cv::Vec3b>(1, 0), cv::Vec3b(18, 17, 16));
  EXPECT_EQ(rgb->depth_mm.at<std::uint16_t>(2, 3), 257);
  const auto gray = from_message(raw_message(image_t::PIXEL_FORMAT_GRAY, 1, 4), &why);
  ASSERT_TRUE(gray) << why;
  EXPECT_EQ(gray->colour_bgr.at<cv::Vec3b>(1, 1), cv::Vec3b(5, 5, 5));
}

TEST(Images, NoDepthImageMeansNoDepth) {
  images_t m = raw_message(image_t::PIXEL_FORMAT_GRAY, 1, 4);
  m.image_types[0] = images_t::RIGHT;
  std::string why;
  const auto frame = from_message(m, &why);
  ASSERT_TRUE(frame) << why;
  EXPECT_EQ(cv::countNonZero(frame->depth_mm), 0);
}

TEST(Images, ContradictionsAreRefusedWithAReason) {
  std::string why;
  images_t m = raw_message(image_t::PIXEL_FORMAT_RGB, 3, 12);
  m.images[1].data.pop_back();
  EXPECT_FALSE(from_message(m, &why));
  EXPECT_THAT(why, testing::HasSubstr("fewer bytes"));
  m = raw_message(image_t::PIXEL_FORMAT_RGB, 3, 12);
  m.images[1].row_stride = -1;
  EXPECT_FALSE(from_message(m, &why));
  m = raw_message(image_t::PIXEL_FORMAT_RGB, 3, 12);
  m.images[1].width = 2'000'000'000;
  EXPECT_FALSE(from_message(m, &why));
  m = raw_message(image_t::PIXEL_FORMAT_RGB, 3, 12);
  m.images[0].width = 3;
  EXPECT_FALSE(from_message(m, &why));
  EXPECT_THAT(why, testing::HasSubstr("differ in size"));
  m.image_types[1] = images_t::MASK_ZIPPED;
  EXPECT_FALSE(from_message(m, &why));
  EXPECT_THAT(why, testing::HasSubstr("no LEFT"));
  m.image_types.clear();
  EXPECT_FALSE(from_message(m, &why));
  EXPECT_THROW(to_message(RgbdFrame{}), std::invalid_argument);
}

}  // namespace
}  // namespace fusion_slam
