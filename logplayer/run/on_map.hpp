// Runs on a saved map: what is checked before, and what is said after.
#pragma once

#include <nlohmann/json.hpp>

#include "logplayer/run/listener.hpp"
#include "logplayer/run/options.hpp"

namespace fusion_slam {

// Throws std::runtime_error, for people, when options name a map that isn't one or isn't whole, or
// when the results would be written into it.
void check_map(const RunOptions& options);

// For metrics.json: the map, the last state, the seconds from the first scan or frame until the
// robot was found.
nlohmann::ordered_json map_metrics(const RunOptions& options,
                                   const LocalizationSummary& localization,
                                   std::int64_t first_sensor_utime_us);

// After a run with MapUse::kContinue: saves the session as a map, joins it to options.map and
// leaves the joined map in OUT/map. options.map is only read. Says on stdout what was joined.
// Returns what went wrong, for people; empty: nothing.
std::string continue_map(const RunOptions& options);

}  // namespace fusion_slam
