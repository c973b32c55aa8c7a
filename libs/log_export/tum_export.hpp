// An LCM log as a TUM RGB-D directory (Sturm et al. 2012), which ORB-SLAM, RTAB-Map and others
// read.
#pragma once

#include "libs/log_export/log_events.hpp"

namespace fusion_slam {

struct TumExportOptions {
  bool keep_jpeg =
      false;  // the log's own JPEG bytes in rgb/*.jpg instead of PNG: a tenth of the size
};

// Makes `directory`, whole or not at all:
//   rgb/SECONDS.png     8-bit colour; depth/SECONDS.png 16-bit, 5000 units a metre, 0: none
//   rgb.txt, depth.txt  "SECONDS rgb/SECONDS.png", by the images' own stamps
//   groundtruth.txt     T_world_camera of the colour camera's optical frame: GROUND_TRUTH and the
//                       mounting of ROBOT_MODEL; without GROUND_TRUTH there is no such file
// rgb.txt's comment holds the intrinsics, which our importer reads: "# camera: fx 570 fy 570 cx
// 319.5 cy 239.5 k1 0 k2 0 p1 0 p2 0 k3 0 width 640 height 480". Depth beyond 13.1 m can't be said
// and becomes none. Throws ExportError: there is no CAMERA in the log, `directory` is not empty, or
// can't be written.
ExportSummary export_tum(const std::filesystem::path& log, const std::filesystem::path& directory,
                         const TumExportOptions& options,
                         const std::function<void(double)>& progress = {});

}  // namespace fusion_slam
