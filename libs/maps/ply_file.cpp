#include "libs/maps/ply_file.hpp"

#include <cstdint>
#include <cstring>

namespace fusion_slam {
namespace {

void append_little_endian(float value, std::string* bytes) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  for (int shift = 0; shift < 32; shift += 8)
    bytes->push_back(static_cast<char>((bits >> shift) & 0xFFU));
}

}  // namespace

std::string ply_bytes(const std::vector<ColouredPoint>& points) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\ncomment Fusion-SLAM, metres, map frame\nelement "
      "vertex " +
      std::to_string(points.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  bytes.reserve(bytes.size() + 15 * points.size());
  for (const ColouredPoint& point : points) {
    for (int axis = 0; axis < 3; ++axis) append_little_endian(point.p_m[axis], &bytes);
    for (const std::uint8_t channel : {point.r, point.g, point.b})
      bytes.push_back(static_cast<char>(channel));
  }
  return bytes;
}

}  // namespace fusion_slam
