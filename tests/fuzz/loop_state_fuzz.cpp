// link: fs_loop_detector
// The loop detector's state, as it stands in its journal. What can be read is written the same way.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "services/loop_detector/loop_detector.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fusion_slam::LoopDetector detector{fusion_slam::RobotModel{}};
  fusion_slam::NoteReader in(data, size);
  if (!detector.restore(&in)) {
    if (detector.sizes().nodes != 0 || detector.sizes().edges != 0) std::abort();
    return 0;
  }
  std::vector<std::uint8_t> bytes;
  fusion_slam::NoteWriter out(&bytes);
  detector.write(&out);
  fusion_slam::LoopDetector again{fusion_slam::RobotModel{}};
  fusion_slam::NoteReader back(bytes.data(), bytes.size());
  if (!again.restore(&back)) std::abort();
  if (again.sizes().nodes != detector.sizes().nodes) std::abort();
  return 0;
}
