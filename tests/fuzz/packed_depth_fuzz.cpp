// link: fs_camera fs_compression
// Packed depth images behind their checksum: the first two bytes are the size, the rest is the
// body, whose version and CRC are made good.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "libs/camera/packed_depth.hpp"
#include "libs/compression/zlib_bytes.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const int width_px = data[0], height_px = data[1];
  const std::uint8_t* body = data + 2;
  const std::size_t body_bytes = size - 2;
  const std::uint32_t crc = fusion_slam::crc32_of(body, body_bytes);
  fusion_slam::Bytes bytes = {1};
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(crc >> (8 * i)));
  bytes.insert(bytes.end(), body, body + body_bytes);
  std::string why;
  const auto depth_mm = fusion_slam::decode_packed_depth(bytes, width_px, height_px, &why);
  if (depth_mm && (depth_mm->cols != width_px || depth_mm->rows != height_px)) std::abort();
  if (!depth_mm && why.empty()) std::abort();
  return 0;
}
