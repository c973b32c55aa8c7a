// An LCM log with its camera's images coded another way: half the size, or for other programs.
#pragma once

#include "libs/camera_messages/images.hpp"
#include "libs/log_export/log_events.hpp"

namespace fusion_slam {

struct LcmExportOptions {
  ImageCoding images = ImageCoding::kPacked;
  int jpeg_quality = 0;  // 30 to 100: colour is encoded anew; 0: it stays as it is
};

// Writes `file`, whole or not at all: all events of `log` in their order and at their times, bytes
// as they were but for CAMERA and KEYFRAME_IMAGE, whose depth is the same in another coding. An
// image that can't be read stays as it was and is counted. Throws ExportError: `file` is `log`, or
// can't be written.
ExportSummary export_lcm(const std::filesystem::path& log, const std::filesystem::path& file,
                         const LcmExportOptions& options,
                         const std::function<void(double)>& progress = {});

}  // namespace fusion_slam
