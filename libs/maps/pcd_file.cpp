#include "libs/maps/pcd_file.hpp"

#include <cstdint>
#include <cstring>

namespace fusion_slam {
namespace {

void append_little_endian(std::uint32_t bits, std::string* bytes) {
  for (int shift = 0; shift < 32; shift += 8)
    bytes->push_back(static_cast<char>((bits >> shift) & 0xFFU));
}

}  // namespace

std::string pcd_bytes(const std::vector<ColouredPoint>& points) {
  const std::string n = std::to_string(points.size());
  std::string bytes =
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\n"
      "TYPE F F F F\nCOUNT 1 1 1 1\nWIDTH " +
      n + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + n + "\nDATA binary\n";
  bytes.reserve(bytes.size() + 16 * points.size());
  for (const ColouredPoint& point : points) {
    for (int axis = 0; axis < 3; ++axis) {
      std::uint32_t bits = 0;
      const float value = point.p_m[axis];
      std::memcpy(&bits, &value, sizeof bits);
      append_little_endian(bits, &bytes);
    }
    append_little_endian(static_cast<std::uint32_t>(point.r) << 16 |
                             static_cast<std::uint32_t>(point.g) << 8 | point.b,
                         &bytes);
  }
  return bytes;
}

}  // namespace fusion_slam
