#include "libs/eventlog/writer.hpp"

#include <cerrno>
#include <cstring>
#include <limits>
#include <stdexcept>

#include <unistd.h>

#include "libs/eventlog/event.hpp"
#include "libs/schema/big_endian.hpp"

namespace fusion_slam {

LogWriter::LogWriter(const std::filesystem::path& path) : path_(path), partial_(path) {
  partial_ += ".partial";
  file_ = std::fopen(partial_.c_str(), "wbe");
  if (file_ == nullptr) {
    throw std::runtime_error(partial_.string() + ": cannot be made: " + std::strerror(errno) +
                             "; does the folder exist, and may you write there?");
  }
}

LogWriter::~LogWriter() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  std::error_code ignored;
  std::filesystem::remove(partial_, ignored);
}

void LogWriter::write(std::int64_t timestamp_us, const std::string& channel,
                      const std::uint8_t* bytes, std::size_t size_bytes) {
  if (file_ == nullptr) throw std::logic_error(path_.string() + ": written to after it was closed");
  if (channel.empty() || channel.size() > 63) {
    throw std::invalid_argument("channel name `" + channel + "` has to have 1 to 63 bytes");
  }
  if (size_bytes > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
    throw std::invalid_argument("a message of " + std::to_string(size_bytes) +
                                " bytes is too large for an LCM log");
  }
  std::uint8_t header[kLogHeaderBytes];
  write_big_endian(kLogSync, 4, header);
  write_big_endian(static_cast<std::uint64_t>(n_events_), 8, header + 4);
  write_big_endian(static_cast<std::uint64_t>(timestamp_us), 8, header + 12);
  write_big_endian(channel.size(), 4, header + 20);
  write_big_endian(size_bytes, 4, header + 24);
  if (std::fwrite(header, 1, sizeof header, file_) != sizeof header ||
      std::fwrite(channel.data(), 1, channel.size(), file_) != channel.size() ||
      (size_bytes > 0 && std::fwrite(bytes, 1, size_bytes, file_) != size_bytes)) {
    fail("written");
  }
  ++n_events_;
  size_bytes_ += kLogHeaderBytes + static_cast<std::int64_t>(channel.size() + size_bytes);
}

void LogWriter::close() {
  if (file_ == nullptr) return;
  if (std::fflush(file_) != 0 || fsync(fileno(file_)) != 0) fail("written");
  std::FILE* file = file_;
  file_ = nullptr;
  std::error_code error;
  if (std::fclose(file) != 0) {
    error = {errno, std::generic_category()};
  } else {
    std::filesystem::rename(partial_, path_, error);
  }
  if (!error) return;
  std::error_code ignored;
  std::filesystem::remove(partial_, ignored);
  throw std::runtime_error(path_.string() + ": cannot be finished: " + error.message());
}

void LogWriter::fail(const std::string& doing) {
  const int error = errno;
  std::fclose(file_);
  file_ = nullptr;
  std::error_code ignored;
  std::filesystem::remove(partial_, ignored);
  throw std::runtime_error(partial_.string() + ": cannot be " + doing + ": " +
                           std::strerror(error) +
                           (error == ENOSPC ? "; free some space and run again" : "") +
                           " (the unfinished file is removed)");
}

}  // namespace fusion_slam
