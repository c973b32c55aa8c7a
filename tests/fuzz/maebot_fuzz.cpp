// link: fs_datasets
// Messages of the MAEBot's own types: what is accepted becomes a scan.
#include <cstdint>
#include <cstdlib>

#include "libs/datasets/maebot.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fusion_slam::MaebotLog log;
  fusion_slam::LogEvent event;
  event.channel = "FUZZ";
  event.data.assign(data, data + size);
  fusion_slam::add_maebot_event(event, &log);
  for (const fusion_slam::MaebotSweep& sweep : log.sweeps)
    if (fusion_slam::to_laser_scan(sweep).ranges_m.size() != sweep.ranges_m.size()) std::abort();
  log.beam_period_s();
  return 0;
}
