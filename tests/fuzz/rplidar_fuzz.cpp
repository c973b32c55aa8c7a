// link: fs_rplidar_protocol
// Bytes off the line: what is handed out is a turn, whatever comes and in whatever pieces.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "drivers/rplidar/answer_parser.hpp"
#include "drivers/rplidar/resample.hpp"
#include "drivers/rplidar/scan_parser.hpp"

namespace {

using fusion_slam::AnswerParser;
using fusion_slam::Revolution;
using fusion_slam::RplidarCommand;
using fusion_slam::ScanFormat;
using fusion_slam::ScanParser;

void require(bool condition) {
  if (!condition) std::abort();
}

void check(const Revolution& turn) {
  require(turn.measurements.size() >= 8 && turn.period_s > 0.0);
  for (const auto& m : turn.measurements) {
    require(m.angle_deg >= 0.0 && m.angle_deg < 360.0);
    require(m.range_m >= 0.0 && m.range_m < 66.0 && m.quality >= 0 && m.quality < 64);
  }
  for (const double beam_period_s : {2.5e-4, 1e-5, 1.0}) {
    const auto scan = fusion_slam::to_laser_scan(turn, beam_period_s);
    require(scan.ranges_m.size() >= fusion_slam::kFewestBeams &&
            scan.ranges_m.size() <= fusion_slam::kMostBeams);
    for (const float range : scan.ranges_m) require(std::isfinite(range) && range >= 0.0F);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const auto format = static_cast<ScanFormat>(data[0] % 3);
  const std::size_t chunk = 1 + data[1];
  data += 2;
  size -= 2;
  ScanParser parser(format, 5e-4, 10.0 / 115'200);
  std::vector<Revolution> turns;
  for (std::size_t i = 0; i < size; i += chunk) {
    const std::size_t n = std::min(chunk, size - i);
    // Arrival times that jump are as hostile as bytes.
    parser.add(data + i, n, static_cast<std::int64_t>(i) * 100 * (data[i] - 100), &turns);
  }
  for (const Revolution& turn : turns) check(turn);
  const auto& seen = parser.counters();
  require(seen.bytes == static_cast<std::int64_t>(size) && seen.skipped_bytes <= seen.bytes);
  require(seen.revolutions == static_cast<std::int64_t>(turns.size()));

  for (const auto command : {RplidarCommand::kGetInfo, RplidarCommand::kGetConf,
                             RplidarCommand::kScan, RplidarCommand::kExpressScan}) {
    AnswerParser answer(command);
    bool whole = false;
    for (std::size_t i = 0; i < size && !whole; i += chunk)
      whole = answer.add(data + i, std::min(chunk, size - i));
    if (!whole) {
      require(!answer.seen().empty());
      continue;
    }
    require(fusion_slam::is_answer_to(command, answer.descriptor()));
    if (answer.descriptor().send_mode == 0) {
      const auto packet = answer.packet();
      fusion_slam::decode_conf(fusion_slam::RplidarConf::kModeName, packet);
    }
    answer.rest();
  }
  return 0;
}
