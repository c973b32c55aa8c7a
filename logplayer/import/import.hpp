// Recording in, standard LCM log out.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

#include "libs/datasets/text.hpp"
#include "logplayer/import/options.hpp"

namespace fusion_slam {

struct ImportSummary {
  std::map<std::string, std::int64_t> messages;  // by channel
  std::int64_t size_bytes = 0;                   // of the log
  std::int64_t largest_message_bytes = 0;
  double duration_s = 0.0;  // of the log
  Skipped skipped;
  std::string place_name;
  std::vector<std::string> notes;
};

// Writes options.output as a whole or not at all. Progress goes to `progress` when it is not null.
// Throws std::runtime_error with the file, the place and what to do.
ImportSummary run_import(const ImportOptions& options, std::ostream* progress);

// For people.
void print_summary(const ImportOptions& options, const ImportSummary& summary, std::ostream& out);

}  // namespace fusion_slam
