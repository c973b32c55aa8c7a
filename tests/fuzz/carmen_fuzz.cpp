// link: fs_datasets
// CARMEN logs: any text gives a log whose scans are in order of time.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "libs/datasets/carmen.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fusion_slam::CarmenLog log =
      fusion_slam::parse_carmen({reinterpret_cast<const char*>(data), size});
  for (std::size_t i = 1; i < log.scans.size(); ++i)
    if (log.scans[i].scan.utime_us <= log.scans[i - 1].scan.utime_us) std::abort();
  const auto odometry = log.raw_odometry();
  for (std::size_t i = 1; i < odometry.size(); ++i)
    if (odometry[i].utime_us <= odometry[i - 1].utime_us) std::abort();
  return 0;
}
