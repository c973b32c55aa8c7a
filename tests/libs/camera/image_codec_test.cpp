#include "libs/camera/image_codec.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

cv::Mat ramp_depth() {
  cv::Mat depth(5, 7, CV_16UC1);
  for (int v = 0; v < 5; ++v)
    for (int u = 0; u < 7; ++u)
      depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(9000 * v + 257 * u);
  return depth;
}

cv::Mat ramp_colour() {
  cv::Mat bgr(24, 32, CV_8UC3);
  for (int v = 0; v < 24; ++v)
    for (int u = 0; u < 32; ++u)
      bgr.at<cv::Vec3b>(v, u) = {static_cast<std::uint8_t>(8 * u),
                                 static_cast<std::uint8_t>(10 * v), 128};
  return bgr;
}

TEST(Depth, BytesAreLittleEndianRowByRow) {
  const Bytes bytes = depth_bytes(ramp_depth());
  ASSERT_EQ(bytes.size(), 70u);
  EXPECT_EQ(bytes[2], 0x01);  // 257
  EXPECT_EQ(bytes[3], 0x01);
  EXPECT_EQ(bytes[14], 9000 & 0xFF);
  EXPECT_EQ(bytes[15], 9000 >> 8);
}

TEST(Depth, ZippedAndRawComeBackTheSame) {
  std::string why;
  const cv::Mat depth = ramp_depth();
  const auto zipped = decode_depth(encode_depth(depth), 7, 5, &why);
  const auto raw = depth_from_bytes(depth_bytes(depth), 7, 5, &why);
  ASSERT_TRUE(zipped && raw) << why;
  EXPECT_EQ(depth_bytes(*zipped), depth_bytes(depth));
  EXPECT_EQ(depth_bytes(*raw), depth_bytes(depth));
}

TEST(Depth, WrongSizesAndDamageAreRefused) {
  std::string why;
  const Bytes zipped = encode_depth(ramp_depth());
  EXPECT_FALSE(decode_depth(zipped, 7, 6, &why));
  EXPECT_FALSE(decode_depth(zipped, 7, 4, &why));
  EXPECT_FALSE(decode_depth(Bytes(zipped.begin(), zipped.end() - 4), 7, 5, &why));
  EXPECT_FALSE(decode_depth({}, 7, 5, &why));
  EXPECT_FALSE(decode_depth(zipped, -7, 5, &why));
  EXPECT_FALSE(decode_depth(zipped, 8000, 8000, &why));  // before 128 MB are allocated
  EXPECT_THAT(why, testing::HasSubstr("too short"));
  EXPECT_FALSE(decode_depth(zipped, 1 << 20, 1 << 20, &why));
  EXPECT_FALSE(depth_from_bytes(Bytes(69), 7, 5, &why));
}

TEST(Jpeg, SizeIsReadFromTheHeader) {
  const Bytes jpeg = encode_jpeg(ramp_colour());
  ASSERT_TRUE(jpeg_size(jpeg));
  EXPECT_EQ(*jpeg_size(jpeg), cv::Size(32, 24));
  EXPECT_FALSE(jpeg_size({}));
  EXPECT_FALSE(jpeg_size(Bytes(100, 0xFF)));
}

TEST(Jpeg, ComesBackNearlyTheSame) {
  std::string why;
  const auto bgr = decode_jpeg(encode_jpeg(ramp_colour()), 32, 24, &why);
  ASSERT_TRUE(bgr) << why;
  for (int v = 0; v < 24; ++v)
    for (int u = 0; u < 32; ++u)
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(bgr->at<cv::Vec3b>(v, u)[k], ramp_colour().at<cv::Vec3b>(v, u)[k], 12);
}

TEST(Jpeg, WrongSizesAndDamageAreRefused) {
  std::string why;
  const Bytes jpeg = encode_jpeg(ramp_colour());
  EXPECT_FALSE(decode_jpeg(jpeg, 31, 24, &why));
  EXPECT_THAT(why, testing::HasSubstr("32 x 24"));
  EXPECT_FALSE(decode_jpeg({1, 2, 3}, 32, 24, &why));
  EXPECT_FALSE(decode_jpeg(jpeg, 0, 24, &why));
  for (std::size_t n = 0; n < jpeg.size(); n += 7)
    decode_jpeg(Bytes(jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(n)), 32, 24, &why);
}

}  // namespace
}  // namespace fusion_slam
