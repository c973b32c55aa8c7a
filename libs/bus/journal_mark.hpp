// What a source does whose journal has lost its end (a power cut): the lost messages were heard,
// so none of their numbers and ids may be given to anything else.
#pragma once

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include "fusion_slam/command_t.hpp"
#include "libs/bus/bus.hpp"

namespace fusion_slam {

// A note of the Bus's own in each journal: a process (`target`) opened it, on which start of the
// machine (`argument`).
constexpr const char* kJournalMark = "JOURNAL";
constexpr const char* kJournalOpened = "opened";  // verb: all is there
constexpr const char* kJournalCut = "cut";        // verb: what came last may be lost

// What a journal that was written anew says of what is left out; target: the channel.
// argument: numbers up to this one were given and are left out; then pairs (from, to) never given.
constexpr const char* kJournalSaid = "said";
// argument: numbers up to this one were handled; then those that were not. utime: of the newest.
constexpr const char* kJournalHeard = "heard";

inline std::string numbers_to_text(const std::vector<std::int64_t>& numbers) {
  std::string text;
  for (const std::int64_t number : numbers) text += std::to_string(number) + " ";
  return text;
}
// Ends at what is no number.
inline std::vector<std::int64_t> numbers_from_text(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::int64_t> numbers;
  for (std::int64_t number = 0; in >> number;) numbers.push_back(number);
  return numbers;
}

// Where counting goes on when nobody knows how many behind `last` are lost: at the beginning of a
// thousand, at least 500 further on (minutes of keyframes; a kernel writes within half a minute).
inline std::int64_t first_after_cut(std::int64_t last) { return (last + 1500) / 1000 * 1000 + 1; }

// Ids of what a source says, while its journal is read back. Made before run().
class SourceIds {
 public:
  explicit SourceIds(Bus& bus) {
    bus.on_note<command_t>(kJournalMark, [this](const command_t& mark) {
      if (mark.verb == kJournalCut) next_ = first_after_cut(next_ - 1);
    });
  }
  void said(std::int64_t id) { next_ = std::max(next_, id + 1); }
  std::int64_t next() const { return next_; }

 private:
  std::int64_t next_ = 1;
};

}  // namespace fusion_slam
