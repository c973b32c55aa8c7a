// A session's log into a LoopReport.
#pragma once

#include <filesystem>

#include "logplayer/loops/loop_report.hpp"

namespace fusion_slam {

// Throws std::runtime_error, for people, when the file can't be read or holds nothing of loops.
LoopReport read_session(const std::filesystem::path& session);

}  // namespace fusion_slam
