// What `fusion-slam info` says of a log: for people, and as JSON.
#pragma once

#include <string>

#include "libs/eventlog/summary.hpp"

namespace fusion_slam {

// Several lines, one a channel, aligned in columns.
std::string text_report(const std::string& file, const LogSummary& summary);

// {"file", "size_bytes", "events", "start_us", "duration_s", "channels": {NAME: {...}}, "damages":
// [{...}]}.
std::string json_report(const std::string& file, const LogSummary& summary);

}  // namespace fusion_slam
