#include "libs/eventlog/summary.hpp"

#include <algorithm>
#include <cstdio>

#include "libs/schema/big_endian.hpp"
#include "libs/schema/guard.hpp"

namespace fusion_slam {

double ChannelSummary::rate_hz() const {
  const double span_us = static_cast<double>(last_log_us) - static_cast<double>(first_log_us);
  return n_messages < 2 || span_us <= 0.0 ? 0.0
                                          : 1e6 * static_cast<double>(n_messages - 1) / span_us;
}

void LogSummary::add(const LogEvent& event) {
  const auto bytes = static_cast<std::int64_t>(event.data.size());
  const bool first = n_events++ == 0;
  first_log_us = first ? event.timestamp_us : std::min(first_log_us, event.timestamp_us);
  last_log_us = first ? event.timestamp_us : std::max(last_log_us, event.timestamp_us);

  ChannelSummary& channel = channels[event.channel];
  if (channel.n_messages++ == 0) {
    channel.first_log_us = event.timestamp_us;
    channel.largest_gap_begin_us = event.timestamp_us;
    channel.min_bytes = channel.max_bytes = bytes;
  } else {
    // Unsigned: time stamps of a damaged log may be any number.
    const auto gap_us = static_cast<std::int64_t>(static_cast<std::uint64_t>(event.timestamp_us) -
                                                  static_cast<std::uint64_t>(channel.last_log_us));
    if (gap_us > channel.largest_gap_us) {
      channel.largest_gap_us = gap_us;
      channel.largest_gap_begin_us = channel.last_log_us;
    }
  }
  channel.last_log_us = event.timestamp_us;
  channel.sum_bytes += bytes;
  channel.min_bytes = std::min(channel.min_bytes, bytes);
  channel.max_bytes = std::max(channel.max_bytes, bytes);
  ++channel
        .messages_by_fingerprint[event.data.size() < 8 ? 0 : read_big_endian(event.data.data(), 8)];
  if (const auto utime = peek_utime(event.data.data(), event.data.size())) {
    if (!channel.first_utime_us) channel.first_utime_us = utime;
    channel.last_utime_us = utime;
  }
}

std::string type_name(std::uint64_t fingerprint) {
  if (fingerprint == 0) return "too short for a type";
  const LcmType* type = builtin_schema().find(fingerprint);
  if (type != nullptr) return type->name;
  char text[40];
  std::snprintf(text, sizeof text, "unknown 0x%016llx",
                static_cast<unsigned long long>(fingerprint));
  return text;
}

LogSummary summarise(LogReader& reader) {
  LogSummary summary;
  summary.size_bytes = reader.size_bytes();
  LogEvent event;
  while (true) {
    while (reader.next(&event)) summary.add(event);
    if (!reader.damage()) return summary;
    summary.damages.push_back(*reader.damage());
    if (!reader.resync()) return summary;
  }
}

}  // namespace fusion_slam
