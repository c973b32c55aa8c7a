// A recorded session at any moment of it: an index of the log's events by the sensors' time, and
// what of them makes up the state then. What a later event replaces (the older revision of a tile,
// an older image) is not read. One thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "libs/eventlog/reader.hpp"
#include "viz/web/viewer_state.hpp"

namespace fusion_slam {

class SessionReplay {
 public:
  // Reads the whole log once; `progress` is told 0 to 1, and may return false to give up (then the
  // index is empty). Throws std::runtime_error, for people, when the file is no log or holds
  // nothing that can be shown.
  SessionReplay(const std::filesystem::path& log, const std::function<bool(double)>& progress);

  std::int64_t first_us() const { return first_us_; }  // sensors' time
  std::int64_t last_us() const { return last_us_; }

  // Brings the state to a moment: forwards by the events between, backwards from the beginning (the
  // state is cleared).
  void go_to(std::int64_t utime_us, ViewerState& state);

  std::size_t events() const { return entries_.size(); }
  std::size_t applied() const { return applied_; }  // events read by go_to so far
  const std::string& damage() const {
    return damage_;
  }  // what is wrong with the log; empty: nothing
  // When loops were closed, for marks on the time line.
  const std::vector<std::int64_t>& closures_us() const { return closures_us_; }

  // A jump further than this leaves out what was replaced by its end; closer to the end all is
  // applied, so that rates are those of the recording.
  static constexpr std::int64_t kWhole_us = 3'000'000;

 private:
  struct Entry {
    std::int64_t offset = 0;
    std::int64_t utime_us = 0;   // newest sensor's when this was logged: never decreases
    std::uint32_t replaces = 0;  // events with the same number replace each other; 0: none does
  };
  void index(const LogEvent& event);
  std::uint32_t number_of(const std::string& what);
  void apply(const Entry& entry, ViewerState& state);

  LogReader reader_;
  std::vector<Entry> entries_;
  std::map<std::string, std::uint32_t> numbers_;
  std::vector<std::int64_t> closures_us_;
  std::int64_t now_us_ = 0;
  std::int64_t first_us_ = 0;
  std::int64_t last_us_ = 0;
  std::size_t next_ = 0;  // the first entry that the state lacks
  std::size_t applied_ = 0;
  std::string damage_;
};

// Hands one event to the state when it is of a kind that is shown; false when it is not, or is
// damaged.
bool apply_event(const LogEvent& event, ViewerState& state);

}  // namespace fusion_slam
