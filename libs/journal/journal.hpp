// An append-only journal of messages, so that a process that is killed can be built up again. The
// file is an LCM event log that lcm-logplayer plays; the 64 bits of an event's number hold its CRC
// (docs/formats.md has the byte table).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "libs/eventlog/event.hpp"

namespace fusion_slam {

struct JournalState {
  std::int64_t n_records = 0;
  std::int64_t whole_bytes = 0;  // up to the end of the last whole record
  std::int64_t cut_bytes = 0;    // behind it: half a record, or damaged
  bool existed = false;          // the file, before it was opened
};

// Hands over all whole records from the start up to the first that is not; nothing when there is no
// such file. Never allocates more than the file is long.
JournalState read_journal(const std::filesystem::path& file,
                          const std::function<void(const LogEvent&)>& on_record);

// One thread at a time.
class Journal {
 public:
  // Goes on behind the last whole record; what follows it (a crash's half record) is cut off.
  // Throws std::runtime_error naming the file when it can't be opened or belongs to something else,
  // or another process writes it. `on_record` is given all whole records.
  explicit Journal(const std::filesystem::path& file,
                   const std::function<void(const LogEvent&)>& on_record = {});
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  // When it returns true the kernel has the record: it survives this process, and a power cut once
  // sync() has returned. False when the disk is full: then the file is as it was.
  bool append(std::int64_t timestamp_us, const std::string& channel, const std::uint8_t* bytes,
              std::size_t size_bytes);
  bool sync();

  const JournalState& state() const { return state_; }

 private:
  std::filesystem::path path_;
  int file_ = -1;
  JournalState state_;
};

}  // namespace fusion_slam
