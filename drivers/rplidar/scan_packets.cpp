#include "drivers/rplidar/scan_packets.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kCapsuleBytes = 84;
constexpr std::size_t kHeadBytes = 4;
constexpr double kFullTurnDeg = 360.0;

unsigned u16(const std::uint8_t* b) { return b[0] | (static_cast<unsigned>(b[1]) << 8); }

void read_express(const std::uint8_t* cabin, std::vector<Capsule::Sample>* out) {
  for (std::size_t i = 0; i < 16; ++i, cabin += 5) {
    const unsigned first = u16(cabin);
    const unsigned second = u16(cabin + 2);
    const unsigned d1 = ((first & 3U) << 4) | (cabin[4] & 0x0FU);
    const unsigned d2 = ((second & 3U) << 4) | (cabin[4] >> 4);
    out->push_back({(first >> 2) * 1e-3, d1 / 8.0});
    out->push_back({(second >> 2) * 1e-3, d2 / 8.0});
  }
}

}  // namespace

const char* to_string(ScanFormat format) {
  switch (format) {
    case ScanFormat::kExpress:
      return "express";
    case ScanFormat::kDense:
      return "dense";
    case ScanFormat::kStandard:
      break;
  }
  return "standard";
}

std::size_t packet_bytes(ScanFormat format) {
  return format == ScanFormat::kStandard ? 5 : kCapsuleBytes;
}

std::size_t samples_per_packet(ScanFormat format) {
  return format == ScanFormat::kStandard ? 1 : format == ScanFormat::kExpress ? 32 : 40;
}

std::optional<StandardNode> decode_node(const std::uint8_t* b) {
  const bool s = (b[0] & 1U) != 0;
  const bool not_s = (b[0] & 2U) != 0;
  const bool check = (b[1] & 1U) != 0;
  const double angle_deg = (u16(b + 1) >> 1) / 64.0;
  if (s == not_s || !check || angle_deg > kFullTurnDeg) return std::nullopt;
  return StandardNode{s, b[0] >> 2, angle_deg, u16(b + 3) * 0.25e-3};
}

std::optional<Capsule> decode_capsule(ScanFormat format, const std::uint8_t* b) {
  if ((b[0] >> 4) != 0xA || (b[1] >> 4) != 0x5) return std::nullopt;
  std::uint8_t checksum = 0;
  for (std::size_t i = 2; i < kCapsuleBytes; ++i) checksum ^= b[i];
  if (checksum != ((b[0] & 0x0FU) | ((b[1] & 0x0FU) << 4))) return std::nullopt;
  Capsule capsule;
  const unsigned head = u16(b + 2);
  capsule.scan_begins = (head & 0x8000U) != 0;
  capsule.start_deg = (head & 0x7FFFU) / 64.0;
  if (capsule.start_deg > kFullTurnDeg) return std::nullopt;
  capsule.samples.reserve(samples_per_packet(format));
  if (format == ScanFormat::kExpress)
    read_express(b + kHeadBytes, &capsule.samples);
  else
    for (std::size_t i = kHeadBytes; i < kCapsuleBytes; i += 2)
      capsule.samples.push_back({u16(b + i) * 1e-3, 0.0});
  return capsule;
}

}  // namespace fusion_slam
