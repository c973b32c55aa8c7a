// One function a format: reads the recording, fills `config` with what it says about the sensors
// (over the robot description given), and returns its events. All throw std::runtime_error
// (DatasetError, ConfigError) when nothing is usable.
#pragma once

#include <functional>

#include "libs/config/robot_config.hpp"
#include "logplayer/import/options.hpp"
#include "logplayer/import/timeline.hpp"

namespace fusion_slam {

Timeline carmen_source(const ImportOptions& options, RobotConfig* config);
Timeline hokuyo_source(const ImportOptions& options, RobotConfig* config);
Timeline maebot_source(const ImportOptions& options, RobotConfig* config);
Timeline seven_scenes_source(const ImportOptions& options, RobotConfig* config);
Timeline tum_source(const ImportOptions& options, RobotConfig* config);

}  // namespace fusion_slam
