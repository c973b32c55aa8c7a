#include "libs/compression/zlib_bytes.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>

#include <libdeflate.h>

namespace fusion_slam {
namespace {

// Level 1: depth of a structured-light camera shrinks to a third and at higher levels hardly
// further.
constexpr int kLevel = 1;
constexpr std::size_t kMostExpansion = 1032;  // deflate's 258 bytes of 2 bits

struct Free {
  void operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }
  void operator()(libdeflate_decompressor* d) const { libdeflate_free_decompressor(d); }
};

// Tables of some 100 KB, made once a thread.
libdeflate_compressor* compressor() {
  thread_local const std::unique_ptr<libdeflate_compressor, Free> kMine(
      libdeflate_alloc_compressor(kLevel));
  return kMine.get();
}

libdeflate_decompressor* decompressor() {
  thread_local const std::unique_ptr<libdeflate_decompressor, Free> kMine(
      libdeflate_alloc_decompressor());
  return kMine.get();
}

}  // namespace

std::vector<std::uint8_t> zlib_compress(const std::uint8_t* raw, std::size_t size_bytes) {
  libdeflate_compressor* const with = compressor();
  if (with == nullptr) throw std::runtime_error("no memory to compress with");
  std::vector<std::uint8_t> out(libdeflate_zlib_compress_bound(with, size_bytes));
  out.resize(libdeflate_zlib_compress(with, raw, size_bytes, out.data(), out.size()));
  if (out.empty())
    throw std::runtime_error("could not compress " + std::to_string(size_bytes) + " bytes");
  return out;
}

std::optional<std::vector<std::uint8_t>> zlib_decompress(const std::uint8_t* data,
                                                         std::size_t size_bytes,
                                                         std::size_t max_size_bytes) {
  const std::size_t most = std::min(max_size_bytes, size_bytes * kMostExpansion);
  std::vector<std::uint8_t> out(std::min(most, std::max<std::size_t>(4096, 8 * size_bytes)));
  for (;;) {
    std::size_t size = 0;
    const libdeflate_result result =
        libdeflate_zlib_decompress(decompressor(), data, size_bytes, out.data(), out.size(), &size);
    if (result == LIBDEFLATE_SUCCESS) {
      out.resize(size);
      return out;
    }
    if (result != LIBDEFLATE_INSUFFICIENT_SPACE || out.size() >= most) return std::nullopt;
    out.resize(std::min(most, 4 * out.size()));
  }
}

bool zlib_decompress_into(const std::uint8_t* data, std::size_t size_bytes, std::uint8_t* raw,
                          std::size_t raw_size_bytes) {
  return libdeflate_zlib_decompress(decompressor(), data, size_bytes, raw, raw_size_bytes,
                                    nullptr) == LIBDEFLATE_SUCCESS;
}

std::uint32_t crc32_of(const std::uint8_t* data, std::size_t size_bytes) {
  return libdeflate_crc32(0, data, size_bytes);
}

}  // namespace fusion_slam
