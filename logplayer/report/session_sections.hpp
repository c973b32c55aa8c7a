// The parts of the report that come from the session's log.
#pragma once

#include <filesystem>

#include "libs/evaluation/trajectory.hpp"
#include "libs/report/page.hpp"
#include "logplayer/report/session_history.hpp"

namespace fusion_slam {

Section process_section(const SessionHistory& history);
Section loop_section(const std::filesystem::path& session, const SessionHistory& history,
                     const Trajectory& way);
Section settings_section(const SessionHistory& history);

}  // namespace fusion_slam
