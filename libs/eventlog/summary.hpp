// What a log holds, channel by channel.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libs/eventlog/event.hpp"
#include "libs/eventlog/reader.hpp"

namespace fusion_slam {

struct ChannelSummary {
  std::map<std::uint64_t, std::int64_t>
      messages_by_fingerprint;  // 0: messages too short to have one
  std::int64_t n_messages = 0;
  std::int64_t sum_bytes = 0;
  std::int64_t min_bytes = 0;
  std::int64_t max_bytes = 0;
  std::int64_t first_log_us = 0;  // the events' own time stamps
  std::int64_t last_log_us = 0;
  std::int64_t largest_gap_us = 0;             // between two events of the channel
  std::int64_t largest_gap_begin_us = 0;       // log time of the event before it
  std::optional<std::int64_t> first_utime_us;  // measurement time, of types that have one
  std::optional<std::int64_t> last_utime_us;

  // Messages a second between the first and the last; 0 when that says nothing.
  double rate_hz() const;
};

struct LogSummary {
  std::map<std::string, ChannelSummary> channels;
  std::int64_t n_events = 0;
  std::int64_t size_bytes = 0;    // of the file
  std::int64_t first_log_us = 0;  // smallest
  std::int64_t last_log_us = 0;   // largest
  std::vector<LogDamage> damages;

  void add(const LogEvent& event);
};

// The builtin type's name, or `unknown 0x...`.
std::string type_name(std::uint64_t fingerprint);

// Reads to the end, across damages.
LogSummary summarise(LogReader& reader);

}  // namespace fusion_slam
