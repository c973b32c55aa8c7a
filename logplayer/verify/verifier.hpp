// Looks for what is wrong in a log: bytes that are no events, messages that no decoder should be
// given, holes in sequence numbers, time that goes backwards.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "libs/eventlog/reader.hpp"
#include "logplayer/verify/stream.hpp"

namespace fusion_slam {

struct VerifyReport {
  std::vector<Finding> findings;  // in the file's order
  std::int64_t n_events = 0;
  std::int64_t n_resent = 0;    // not faults: what the bus repaired
  std::int64_t n_restarts = 0;  // nor these
  std::int64_t n_jitter = 0;    // log time steps back as lcm-logger's own does
  std::map<std::pair<std::string, std::uint64_t>, std::int64_t>
      foreign;  // (channel, fingerprint): messages, not a fault
};

// Reads to the end, across damages.
VerifyReport verify(LogReader& reader);

// At most max_lines findings, then a summary.
std::string text_report(const std::string& file, const VerifyReport& report, std::size_t max_lines);

}  // namespace fusion_slam
