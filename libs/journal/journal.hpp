// An append-only journal of messages, so that a process that is killed can be built up again. The
// file is an LCM event log that lcm-logplayer plays; the 64 bits of an event's number hold its CRC
// (docs/formats.md has the byte table).
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <thread>

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

  // Writing it anew, with what is still needed, so that it doesn't grow for ever: begin_anew(),
  // then append_anew() for each record to keep, then finish_anew(). The new file (`FILE.new`) takes
  // the old one's place once it is on the disk, at one of the next append() or settle(): until
  // then each append() goes into both, and a crash leaves the old one whole. False: the disk is
  // full; the old one goes on.
  bool begin_anew();
  bool append_anew(std::int64_t timestamp_us, const std::string& channel, const std::uint8_t* bytes,
                   std::size_t size_bytes);
  bool finish_anew();
  void abandon_anew();  // the old one goes on
  void settle();
  bool is_renewed() const { return anew_.file >= 0; }  // begun, not in its place yet

  const JournalState& state() const { return current_.state; }
  // A record of the old file, by its offset. Nothing when it is damaged.
  std::optional<LogEvent> record_at(std::int64_t offset_bytes, std::int64_t number) const;
  // Of the new file when there is one, else of the old: where the next record will begin.
  const JournalState& newest() const { return is_renewed() ? anew_.state : current_.state; }

 private:
  struct File {
    int file = -1;
    JournalState state;
  };
  static bool write_record(std::int64_t timestamp_us, const std::string& channel,
                           const std::uint8_t* bytes, std::size_t size_bytes, File* file);
  std::filesystem::path path_anew() const { return path_.string() + ".new"; }
  void take_its_place();  // when the new one is on the disk
  void wait_for_disk();

  std::filesystem::path path_;
  File current_;
  File anew_;
  std::thread syncing_;  // touches nothing but the new file's descriptor and these two
  std::atomic<bool> synced_{false};
  std::atomic<bool> sync_failed_{false};
};

}  // namespace fusion_slam
