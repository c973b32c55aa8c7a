// A log as calibration wants it: sampled depth, scans, and the LiDAR's motion by scan matching
// alone.
#pragma once

#include <filesystem>
#include <functional>

#include "libs/calibration/drive.hpp"

namespace fusion_slam {

// Throws std::runtime_error naming the channel that is missing. `progress` gets 0 to 1.
CalibrationDrive read_drive(const std::filesystem::path& log,
                            const std::function<void(double)>& progress = {});

}  // namespace fusion_slam
