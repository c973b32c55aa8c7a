// A virtual world as bytes of a scan, and turns held against it.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/rplidar/scan_parser.hpp"
#include "tests/support/virtual_rplidar/wire.hpp"
#include "tests/support/virtual_rplidar/world.hpp"

namespace fusion_slam {

constexpr double kPeriod_s = 5e-4;
constexpr double kByte_s = 10.0 / 115'200;
constexpr std::int64_t kBegin_us = 1'000'000'000;

// All turns, one packet after the other, one sample of the world a sample.
Bytes encode(const VirtualWorld& world, ScanFormat format);

// Gives the bytes to the parser, `chunk` at a time. Each chunk arrives when its last byte's sample
// was measured and its packet sent.
std::vector<Revolution> parse(ScanParser* parser, const Bytes& bytes, std::size_t chunk,
                              ScanFormat format = ScanFormat::kStandard);

// Beams of `turn` that no sample of the world's best fitting turn explains: 2 mm, or its
// neighbours'.
int wrong_beams(const Revolution& turn, const VirtualWorld& world);

}  // namespace fusion_slam
