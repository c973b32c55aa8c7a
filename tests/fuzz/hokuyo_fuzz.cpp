// link: fs_datasets
// Mines Hokuyo text: every record has 682 ranges.
#include <cstdint>
#include <cstdlib>

#include "libs/datasets/hokuyo.hpp"
#include "libs/datasets/wheel_odometry.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fusion_slam::HokuyoLog log =
      fusion_slam::parse_mines_hokuyo({reinterpret_cast<const char*>(data), size});
  for (const fusion_slam::HokuyoRecord& r : log.records) {
    if (r.scan.ranges_m.size() != 682) std::abort();
    fusion_slam::wheel_motion(fusion_slam::kMinesRoverWheels, {}, {0, r.left_ticks, r.right_ticks});
  }
  return 0;
}
