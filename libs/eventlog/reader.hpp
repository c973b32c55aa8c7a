// Reads LCM event logs, from start to end, without LCM. One thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "libs/eventlog/event.hpp"

namespace fusion_slam {

// Where and why an event can't be read.
struct LogDamage {
  std::int64_t offset_bytes = 0;
  bool at_end = false;  // the file stops within an event: what came before is whole
  std::string message;  // file, byte, what was expected, what to do
};

class LogReader {
 public:
  // Throws std::runtime_error, for people, when the file can't be opened, is empty, or is no LCM
  // event log.
  explicit LogReader(const std::filesystem::path& path);
  ~LogReader();
  LogReader(const LogReader&) = delete;
  LogReader& operator=(const LogReader&) = delete;

  // The next event. False at the end of the file and at a damage: ask damage() which of them. Never
  // allocates more than the file is long.
  bool next(LogEvent* event);

  // Set when next() met something that is no event; next() stays false until resync().
  const std::optional<LogDamage>& damage() const { return damage_; }

  // After a damage: goes on at the next place that looks like a whole event (its sync word,
  // plausible lengths, and again a sync word or the end behind it). False when there is none.
  // Clears damage().
  bool resync();

  // Continues at `offset_bytes`, the start of an event. Clears damage().
  void seek(std::int64_t offset_bytes);

  std::int64_t offset_bytes() const { return offset_; }  // where next() reads
  std::int64_t size_bytes() const { return size_; }      // of the file when it was opened
  const std::filesystem::path& path() const { return path_; }

 private:
  struct Header;
  const std::uint8_t* view(std::int64_t offset, std::int64_t n_bytes);
  bool sync_at(std::int64_t offset);
  std::optional<LogDamage> read_header(std::int64_t offset, Header* header);
  std::int64_t find_sync(std::int64_t from, std::int64_t to);
  void check_is_log();
  LogDamage damaged(std::int64_t offset, const std::string& what) const;

  std::filesystem::path path_;
  int file_ = -1;
  std::int64_t size_ = 0;
  std::int64_t offset_ = 0;
  std::optional<LogDamage> damage_;
  std::vector<std::uint8_t> buffer_;  // bytes buffer_begin_... of the file
  std::int64_t buffer_begin_ = 0;
};

}  // namespace fusion_slam
