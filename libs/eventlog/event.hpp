// One event of an LCM event log. On disk, all numbers big-endian (docs/formats.md has the byte
// table):
//   uint32 0xEDA1DA01, int64 event number, int64 timestamp (us), int32 channel length, int32 data
//   length, channel, data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fusion_slam {

constexpr std::uint32_t kLogSync = 0xEDA1DA01;
constexpr std::int64_t kLogHeaderBytes = 28;
constexpr std::int64_t kMaxLogChannelBytes =
    999;  // what liblcm's own reader accepts; LCM itself sends 63 at most

struct LogEvent {
  std::int64_t offset_bytes = 0;  // of its sync word in the file
  std::int64_t number = 0;        // as in the file: 0, 1, 2 ...
  std::int64_t timestamp_us = 0;  // when it was logged, us since the epoch
  std::string channel;
  std::vector<std::uint8_t> data;  // from the fingerprint on
};

}  // namespace fusion_slam
