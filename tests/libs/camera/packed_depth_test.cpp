#include "libs/camera/packed_depth.hpp"

#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "libs/compression/zlib_bytes.hpp"

namespace fusion_slam {
namespace {

// A wall that runs away, a box before it, a window without depth; steps of disparity, noise of one.
cv::Mat room(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  cv::Mat depth(height, width, CV_16UC1);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const bool box = u > width / 3 && u < width / 2 && v > height / 2;
      const int disparity = (box ? 500 : 120 + u / 4 + v / 8) + static_cast<int>(random() % 3);
      const bool none = (u > 3 * width / 4 && v < height / 3) || random() % 50 == 0;
      depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(none ? 0 : 400000 / disparity);
    }
  return depth;
}

void expect_comes_back(const cv::Mat& depth) {
  std::string why;
  const auto back = decode_packed_depth(encode_packed_depth(depth), depth.cols, depth.rows, &why);
  ASSERT_TRUE(back) << why;
  EXPECT_EQ(cv::norm(*back, depth, cv::NORM_INF), 0.0);
}

TEST(PackedDepth, ComesBackAsItWas) {
  expect_comes_back(room(160, 120, 1));
  expect_comes_back(room(1, 37, 2));
  expect_comes_back(room(37, 1, 3));
  expect_comes_back(cv::Mat::zeros(24, 32, CV_16UC1));
  expect_comes_back(cv::Mat(24, 32, CV_16UC1, cv::Scalar(65535)));
}

TEST(PackedDepth, AnyImageComesBack) {
  std::mt19937 random(4);
  for (const unsigned most : {2U, 300U, 5000U, 65536U}) {
    cv::Mat depth(60, 80, CV_16UC1);
    for (int i = 0; i < 60 * 80; ++i)
      depth.at<std::uint16_t>(i / 80, i % 80) = static_cast<std::uint16_t>(random() % most);
    expect_comes_back(depth);
  }
}

TEST(PackedDepth, PartOfALargerImageComesBack) {
  const cv::Mat depth = room(64, 48, 5);
  expect_comes_back(depth(cv::Rect(5, 7, 40, 30)));
}

TEST(PackedDepth, TwoThirdsOfWhatZlibNeeds) {
  const cv::Mat depth = room(320, 240, 6);
  EXPECT_LT(3 * encode_packed_depth(depth).size(), 2 * encode_depth(depth).size());
}

TEST(PackedDepth, EachDamagedByteIsNoticed) {
  const cv::Mat depth = room(32, 24, 7);
  const Bytes good = encode_packed_depth(depth);
  std::string why;
  for (std::size_t i = 0; i < good.size(); ++i) {
    Bytes bad = good;
    bad[i] = static_cast<std::uint8_t>(bad[i] ^ 0x10);
    EXPECT_FALSE(decode_packed_depth(bad, 32, 24, &why)) << "byte " << i;
    bad.resize(i);
    EXPECT_FALSE(decode_packed_depth(bad, 32, 24, &why)) << "cut to " << i;
  }
  EXPECT_FALSE(decode_packed_depth(good, 32, 25, &why));
  EXPECT_FALSE(decode_packed_depth(good, 31, 24, &why));
  EXPECT_FALSE(decode_packed_depth(good, 0, 24, &why));
  EXPECT_FALSE(decode_packed_depth(good, 1 << 20, 1 << 20, &why));
}

// Bytes that somebody else has made: whatever they say, nothing is read or written beside memory.
TEST(PackedDepth, WrongBytesWithARightChecksumDoNoHarm) {
  const Bytes good = encode_packed_depth(room(24, 17, 8));
  std::string why;
  for (std::size_t i = 5; i < good.size(); ++i)
    for (const int change : {0x01, 0x80, 0xFF}) {
      Bytes bad = good;
      bad[i] = static_cast<std::uint8_t>(bad[i] ^ change);
      const std::uint32_t crc = crc32_of(bad.data() + 5, bad.size() - 5);
      for (std::size_t b = 0; b < 4; ++b) bad[1 + b] = static_cast<std::uint8_t>(crc >> (8 * b));
      const auto depth = decode_packed_depth(bad, 24, 17, &why);
      if (depth) {
        EXPECT_EQ(depth->size(), cv::Size(24, 17));
      }
    }
}

// The bytes as docs/formats.md describes them: two pixels of 1000 mm.
TEST(PackedDepth, GoldenBytes) {
  const cv::Mat depth(1, 2, CV_16UC1, cv::Scalar(1000));
  Bytes golden{1, 0,    0,   0, 0,  // version, CRC-32
               1, 0xE8, 0x07};      // one value: 1000
  const Bytes coded = encode_packed_depth(depth);
  ASSERT_GT(coded.size(), golden.size());
  for (std::size_t i = 1; i < 5; ++i) golden[i] = coded[i];
  // First pixel: all neighbours missing (context 43), the second: those above (context 42).
  for (int c = 0; c < 64; ++c) {
    if (c != 42 && c != 43) {
      golden.push_back(63);
      continue;
    }
    golden.insert(golden.end(), {30, 1, 0x80, 0x10});  // symbol 30 alone, 2048 of 2048
  }
  golden.push_back(4);  // bytes of the upper half
  for (int half = 0; half < 2; ++half)
    golden.insert(golden.end(), {0, 0, 1, 0});  // the state: nothing was left to say
  EXPECT_EQ(coded, golden);
}

TEST(PackedDepth, WhatIsNoDepthImageIsRefused) {
  EXPECT_THROW(encode_packed_depth(cv::Mat(4, 4, CV_8UC1)), std::invalid_argument);
  EXPECT_THROW(encode_packed_depth(cv::Mat()), std::invalid_argument);
}

}  // namespace
}  // namespace fusion_slam
