// The three data formats of a scan, one packet at a time: pure functions from bytes. Angles are
// degrees clockwise as the device gives them, ranges m, 0: no return.
//
//   standard, 5 bytes (figure 4-4)       quality:6 !S S | angle:7 C | angle:8 | distance:16
//       S: first of a turn; C: always 1; angle in 1/64 degree, distance in 1/4 mm
//   express, 84 bytes (figures 4-11..13) A chk:4 | 5 chk:4 | start angle:15 S | 16 cabins of two
//   samples
//       cabin: distance1:14 d1:2 | distance2:14 d2:2 | d2:4 d1:4     distance in mm, d in 1/8
//       degree
//   dense, 84 bytes (figure 4-19)        the same head | 40 distances:16 in mm
//
// chk is the XOR of the bytes from the third on. The document calls the top bit of d a sign.
// Physically d is the parallax between lens and laser, 8 degrees for far objects and 0 at 0.17 m,
// as large as 6 unsigned bits hold and twice what a sign would leave; Slamtec's own SDK reads it
// unsigned, and so do we.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace fusion_slam {

enum class ScanFormat { kStandard, kExpress, kDense };

const char* to_string(ScanFormat format);  // "standard", "express", "dense"
std::size_t packet_bytes(ScanFormat format);
std::size_t samples_per_packet(ScanFormat format);

struct StandardNode {
  bool turn_begins = false;
  int quality = 0;  // 0 to 63
  double angle_deg = 0.0;
  double range_m = 0.0;
};
// Nothing when S, !S and C do not fit or the angle is beyond 360 degrees.
std::optional<StandardNode> decode_node(const std::uint8_t* five_bytes);

struct Capsule {
  bool scan_begins = false;  // S: first packet after the request, what came before is void
  double start_deg = 0.0;    // where the turning part stood at the first sample
  struct Sample {
    double range_m = 0.0;
    double parallax_deg = 0.0;  // to be subtracted from the turning part's angle
  };
  std::vector<Sample> samples;
};
// Nothing when the sync nibbles or the checksum do not fit or the angle is beyond 360 degrees.
// `format` is express or dense.
std::optional<Capsule> decode_capsule(ScanFormat format, const std::uint8_t* bytes);

}  // namespace fusion_slam
