#include "libs/tiles/tile.hpp"

#include "libs/compression/zlib_bytes.hpp"

namespace fusion_slam {

std::vector<std::uint8_t> deflate_bytes(const std::vector<std::uint8_t>& raw) {
  if (raw.empty()) return {};
  return zlib_compress(raw.data(), raw.size());
}

std::optional<std::vector<std::uint8_t>> inflate_bytes(const std::uint8_t* data, std::size_t size,
                                                       std::size_t max_size_bytes) {
  if (size == 0) return std::vector<std::uint8_t>();
  return zlib_decompress(data, size, max_size_bytes);
}

}  // namespace fusion_slam
