// An imported log, read back with the generated decoders.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "libs/eventlog/reader.hpp"

namespace fusion_slam {

struct DecodedLog {
  std::vector<LogEvent> events;

  explicit DecodedLog(const std::filesystem::path& path) {
    LogReader reader(path);
    LogEvent event;
    while (reader.next(&event)) events.push_back(event);
    EXPECT_FALSE(reader.damage());
    for (std::size_t i = 1; i < events.size(); ++i)
      EXPECT_LE(events[i - 1].timestamp_us, events[i].timestamp_us);
  }
  std::map<std::string, int> counts() const {
    std::map<std::string, int> counts;
    for (const LogEvent& e : events) ++counts[e.channel];
    return counts;
  }
  // All messages of a channel; each must decode to its last byte and carry the event's time.
  template <typename Message>
  std::vector<Message> messages(const std::string& channel) const {
    std::vector<Message> result;
    for (const LogEvent& e : events) {
      if (e.channel != channel) continue;
      Message message;
      const auto size = static_cast<int>(e.data.size());
      EXPECT_EQ(message.decode(e.data.data(), 0, size), size) << channel;
      EXPECT_EQ(message.utime, e.timestamp_us);
      result.push_back(message);
    }
    return result;
  }
};

}  // namespace fusion_slam
