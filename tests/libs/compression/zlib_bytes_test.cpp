#include "libs/compression/zlib_bytes.hpp"

#include <random>

#include <gtest/gtest.h>
#include <zlib.h>

namespace fusion_slam {
namespace {

using Bytes = std::vector<std::uint8_t>;

// Runs of equal bytes between random ones, as depth and maps are.
Bytes example(std::size_t size) {
  std::mt19937 random(5);
  Bytes bytes;
  while (bytes.size() < size) {
    bytes.insert(bytes.end(), random() % 40, static_cast<std::uint8_t>(random()));
    bytes.push_back(static_cast<std::uint8_t>(random()));
  }
  bytes.resize(size);
  return bytes;
}

TEST(ZlibBytes, AreReadByZlib) {
  for (const std::size_t size : {1UL, 100UL, 70'000UL, 614'400UL}) {
    const Bytes raw = example(size);
    const Bytes packed = zlib_compress(raw.data(), raw.size());
    EXPECT_EQ(packed, zlib_compress(raw.data(), raw.size()));
    Bytes back(size);
    uLongf n = size;
    ASSERT_EQ(uncompress(back.data(), &n, packed.data(), packed.size()), Z_OK);
    EXPECT_EQ(n, size);
    EXPECT_EQ(back, raw);
  }
}

TEST(ZlibBytes, ReadWhatZlibWrites) {
  for (const std::size_t size : {1UL, 100UL, 70'000UL, 614'400UL})
    for (const int level : {0, 1, 9}) {
      const Bytes raw = example(size);
      uLongf n = compressBound(size);
      Bytes packed(n);
      ASSERT_EQ(compress2(packed.data(), &n, raw.data(), size, level), Z_OK);
      EXPECT_EQ(zlib_decompress(packed.data(), n, size), raw);
      EXPECT_EQ(zlib_decompress(packed.data(), n, 10 * size), raw);
      EXPECT_FALSE(zlib_decompress(packed.data(), n, size - 1));
      Bytes back(size);
      EXPECT_TRUE(zlib_decompress_into(packed.data(), n, back.data(), size));
      EXPECT_EQ(back, raw);
      EXPECT_FALSE(zlib_decompress_into(packed.data(), n, back.data(), size - 1));
      back.resize(size + 1);
      EXPECT_FALSE(zlib_decompress_into(packed.data(), n, back.data(), size + 1));
    }
}

TEST(ZlibBytes, ManyTimesLargerThanPacked) {
  const Bytes raw(5'000'000, 7);
  const Bytes packed = zlib_compress(raw.data(), raw.size());
  EXPECT_LT(packed.size(), raw.size() / 200);
  EXPECT_EQ(zlib_decompress(packed.data(), packed.size(), raw.size()), raw);
}

TEST(ZlibBytes, DamageGivesNothing) {
  const Bytes raw = example(5000);
  const Bytes packed = zlib_compress(raw.data(), raw.size());
  for (std::size_t n = 0; n < packed.size(); n += 7)
    EXPECT_FALSE(zlib_decompress(packed.data(), n, raw.size())) << n;
  for (std::size_t i = 0; i < packed.size(); i += 3) {
    Bytes damaged = packed;
    damaged[i] ^= 0x10;
    const auto back = zlib_decompress(damaged.data(), damaged.size(), raw.size());
    EXPECT_TRUE(!back || *back == raw) << i;  // a bit of padding may be anything
  }
  EXPECT_FALSE(zlib_decompress(nullptr, 0, 100));
  const Bytes noise = example(300);
  EXPECT_FALSE(zlib_decompress(noise.data(), noise.size(), 1 << 30));
}

}  // namespace
}  // namespace fusion_slam
