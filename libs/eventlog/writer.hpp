// Writes LCM event logs that lcm-logplayer plays. The events go to FILE.partial, which becomes FILE
// in close(): a FILE is always whole. One thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

namespace fusion_slam {

class LogWriter {
 public:
  // Throws std::runtime_error when FILE.partial can't be made.
  explicit LogWriter(const std::filesystem::path& path);
  // Without close(): removes FILE.partial and leaves an older FILE as it was.
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  // Appends an event, numbered 0, 1, 2 ... Throws std::runtime_error when the disk is full (nothing
  // is left behind but what the destructor removes), and std::invalid_argument for a channel name
  // that LCM can't send (1 to 63 bytes).
  void write(std::int64_t timestamp_us, const std::string& channel, const std::uint8_t* bytes,
             std::size_t size_bytes);
  void write(std::int64_t timestamp_us, const std::string& channel,
             const std::vector<std::uint8_t>& data) {
    write(timestamp_us, channel, data.data(), data.size());
  }

  // Brings everything to the disk and gives the file its name. Throws std::runtime_error. Writes
  // nothing afterwards.
  void close();

  std::int64_t n_events() const { return n_events_; }
  std::int64_t size_bytes() const { return size_bytes_; }

 private:
  [[noreturn]] void fail(const std::string& doing);

  std::filesystem::path path_;
  std::filesystem::path partial_;
  std::FILE* file_ = nullptr;
  std::int64_t n_events_ = 0;
  std::int64_t size_bytes_ = 0;
};

}  // namespace fusion_slam
