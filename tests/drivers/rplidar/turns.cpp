#include "tests/drivers/rplidar/turns.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {

Bytes encode(const VirtualWorld& world, ScanFormat format) {
  std::vector<wire::Sample> samples;
  for (const VirtualTurn& turn : world.turns)
    for (std::size_t i = 0; i < turn.samples.size(); ++i) {
      const VirtualSample& s = turn.samples[i];
      const double raw_deg =
          360.0 * static_cast<double>(i) / static_cast<double>(turn.samples.size());
      samples.push_back({raw_deg, s.angle_deg, s.range_m, s.quality, i == 0});
    }
  Bytes bytes;
  const std::size_t n = samples_per_packet(format);
  for (std::size_t i = 0; i + n <= samples.size(); i += n) {
    const std::vector<wire::Sample> group(samples.begin() + static_cast<std::ptrdiff_t>(i),
                                          samples.begin() + static_cast<std::ptrdiff_t>(i + n));
    const Bytes packet = format == ScanFormat::kStandard  ? wire::standard_node(group.front())
                         : format == ScanFormat::kExpress ? wire::express_capsule(group, i == 0)
                                                          : wire::dense_capsule(group, i == 0);
    bytes.insert(bytes.end(), packet.begin(), packet.end());
  }
  return bytes;
}

std::vector<Revolution> parse(ScanParser* parser, const Bytes& bytes, std::size_t chunk,
                              ScanFormat format) {
  std::vector<Revolution> turns;
  const double packet = static_cast<double>(packet_bytes(format));
  const double samples = static_cast<double>(samples_per_packet(format));
  for (std::size_t i = 0; i < bytes.size(); i += chunk) {
    const std::size_t n = std::min(chunk, bytes.size() - i);
    // The packet that byte i + n - 1 belongs to was complete with its last sample, and then sent.
    const double packets = std::ceil(static_cast<double>(i + n) / packet);
    const double left = packets * packet - static_cast<double>(i + n);  // bytes still to come
    const double end_s = (packets * samples - 1.0) * kPeriod_s + (packet - left) * kByte_s;
    parser->add(&bytes[i], n, kBegin_us + std::llround(1e6 * end_s), &turns);
  }
  return turns;
}

int wrong_beams(const Revolution& turn, const VirtualWorld& world) {
  int best = static_cast<int>(turn.measurements.size());
  for (const VirtualTurn& truth : world.turns) {
    const auto n = static_cast<std::int64_t>(truth.samples.size());
    int wrong = 0;
    for (const Measurement& m : turn.measurements) {
      const auto at = static_cast<std::int64_t>(m.angle_deg / 360.0 * static_cast<double>(n));
      bool explained = false;
      for (std::int64_t i = at - 1; i <= at + 1; ++i)
        explained =
            explained || std::abs(truth.samples[static_cast<std::size_t>((i + n) % n)].range_m -
                                  m.range_m) < 2e-3;
      if (!explained) ++wrong;
    }
    best = std::min(best, wrong);
  }
  return best;
}

}  // namespace fusion_slam
