#include "libs/eventlog/reader.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "libs/schema/big_endian.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kReadAheadBytes = 1 << 18;
constexpr std::int64_t kForeignSearchBytes =
    1 << 16;  // a log may begin with a damage; a foreign file has no sync word

// What a file that is no log seems to be, and what to do about it.
std::string foreign_hint(const std::vector<std::uint8_t>& head) {
  const std::string text(head.begin(), head.end());
  if (text.compare(0, 2, "\x1f\x8b") == 0) return "it is gzip: unpack it first (gunzip)";
  if (text.compare(0, 7, "#ROSBAG") == 0) return "it is a ROS bag";
  if (text.compare(0, 2, "PK") == 0) return "it is a zip archive: unpack it first (unzip)";
  if (text.find("FLASER") != std::string::npos || text.find("RAWLASER") != std::string::npos ||
      text.compare(0, 5, "PARAM") == 0) {
    return "it looks like a CARMEN log: `fusion-slam import carmen` makes an LCM log of it";
  }
  return "see `fusion-slam import --help` for the formats that can be turned into one";
}

}  // namespace

struct LogReader::Header {
  std::int64_t number = 0;
  std::int64_t timestamp_us = 0;
  std::int64_t channel_bytes = 0;
  std::int64_t data_bytes = 0;
  std::int64_t total() const { return kLogHeaderBytes + channel_bytes + data_bytes; }
};

LogReader::LogReader(const std::filesystem::path& path) : path_(path) {
  file_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0)
    throw std::runtime_error(path.string() + ": cannot be opened: " + std::strerror(errno));
  try {
    struct stat info {};
    if (fstat(file_, &info) != 0 || !S_ISREG(info.st_mode)) {
      throw std::runtime_error(path.string() +
                               ": is not a file; give the path of an LCM event log");
    }
    size_ = info.st_size;
    check_is_log();
  } catch (...) {
    close(file_);
    throw;
  }
}

LogReader::~LogReader() { close(file_); }

void LogReader::check_is_log() {
  if (size_ == 0) {
    throw std::runtime_error(
        path_.string() +
        ": the file is empty (0 bytes): nothing was recorded. `fusion-slam doctor` tells whether "
        "this machine's multicast works");
  }
  if (find_sync(0, std::min(size_, kForeignSearchBytes)) >= 0) return;
  const std::int64_t n = std::min<std::int64_t>(size_, 4096);
  const std::uint8_t* head = view(0, n);
  throw std::runtime_error(
      path_.string() + ": is not an LCM event log (it should begin with the bytes ED A1 DA 01): " +
      foreign_hint(head == nullptr ? std::vector<std::uint8_t>()
                                   : std::vector<std::uint8_t>(head, head + n)));
}

bool LogReader::next(LogEvent* event) {
  if (damage_ || offset_ >= size_) return false;
  Header header;
  damage_ = read_header(offset_, &header);
  if (damage_) return false;
  const std::uint8_t* bytes = view(offset_, header.total());
  if (bytes == nullptr) {
    damage_ =
        damaged(offset_,
                "the file became shorter while it was read; copy it to a local disk and try again");
    return false;
  }
  event->offset_bytes = offset_;
  event->number = header.number;
  event->timestamp_us = header.timestamp_us;
  const std::uint8_t* channel = bytes + kLogHeaderBytes;
  event->channel.assign(channel, channel + header.channel_bytes);
  event->data.assign(channel + header.channel_bytes, bytes + header.total());
  offset_ += header.total();
  return true;
}

bool LogReader::resync() {
  const std::int64_t from = damage_ ? damage_->offset_bytes + 1 : offset_;
  damage_.reset();
  Header header;
  for (offset_ = find_sync(from, size_); offset_ >= 0; offset_ = find_sync(offset_ + 1, size_)) {
    if (!read_header(offset_, &header)) return true;
  }
  offset_ = size_;
  return false;
}

void LogReader::seek(std::int64_t offset_bytes) {
  offset_ = std::clamp<std::int64_t>(offset_bytes, 0, size_);
  damage_.reset();
}

std::optional<LogDamage> LogReader::read_header(std::int64_t offset, Header* header) {
  const auto cut = [&](std::int64_t needed) {
    LogDamage damage =
        damaged(offset, "the event needs " + std::to_string(needed) +
                            " bytes but the file ends after " + std::to_string(size_ - offset) +
                            ": the recording was cut; every event before this one is whole");
    damage.at_end = true;
    return damage;
  };
  if (size_ - offset >= 4 && !sync_at(offset)) {
    return damaged(
        offset,
        "expected the sync bytes ED A1 DA 01 of an event; bytes were overwritten or are missing");
  }
  if (size_ - offset < kLogHeaderBytes) return cut(kLogHeaderBytes);
  const std::uint8_t* bytes = view(offset, kLogHeaderBytes);
  if (bytes == nullptr) return cut(kLogHeaderBytes);
  header->number = read_signed_big_endian(bytes + 4, 8);
  header->timestamp_us = read_signed_big_endian(bytes + 12, 8);
  header->channel_bytes = read_signed_big_endian(bytes + 20, 4);
  header->data_bytes = read_signed_big_endian(bytes + 24, 4);
  if (header->channel_bytes < 1 || header->channel_bytes > kMaxLogChannelBytes) {
    return damaged(offset, "a channel name of " + std::to_string(header->channel_bytes) +
                               " bytes is impossible (1 to " + std::to_string(kMaxLogChannelBytes) +
                               ")");
  }
  if (header->data_bytes < 0) {
    return damaged(offset,
                   "a message of " + std::to_string(header->data_bytes) + " bytes is impossible");
  }
  const std::int64_t end = offset + header->total();
  if (end > size_) return cut(header->total());
  if (size_ - end >= 4 && !sync_at(end)) {
    return damaged(offset, "the event's lengths lead to byte " + std::to_string(end) +
                               ", where no event begins; bytes were overwritten or are missing");
  }
  return std::nullopt;
}

LogDamage LogReader::damaged(std::int64_t offset, const std::string& what) const {
  return {offset, false, path_.string() + ": byte " + std::to_string(offset) + ": " + what};
}

bool LogReader::sync_at(std::int64_t offset) {
  const auto held = static_cast<std::int64_t>(buffer_.size());
  if (offset >= buffer_begin_ && offset + 4 <= buffer_begin_ + held) {
    return read_big_endian(buffer_.data() + (offset - buffer_begin_), 4) == kLogSync;
  }
  // Far ahead: not worth moving the buffer there and back.
  std::uint8_t bytes[4];
  return pread(file_, bytes, sizeof bytes, offset) == sizeof bytes &&
         read_big_endian(bytes, 4) == kLogSync;
}

// First sync word at or behind `from` that ends before `to`; -1: none.
std::int64_t LogReader::find_sync(std::int64_t from, std::int64_t to) {
  const std::uint8_t sync[4] = {0xED, 0xA1, 0xDA, 0x01};
  for (std::int64_t begin = from; begin + 4 <= to;) {
    const std::int64_t n = std::min(to - begin, kReadAheadBytes);
    const std::uint8_t* bytes = view(begin, n);
    if (bytes == nullptr) return -1;
    const std::uint8_t* found = std::search(bytes, bytes + n, sync, sync + 4);
    if (found != bytes + n) return begin + (found - bytes);
    begin += n - 3;
  }
  return -1;
}

// Bytes [offset, offset + n_bytes) of the file, valid until the next call; nullptr when the file
// doesn't hold them.
const std::uint8_t* LogReader::view(std::int64_t offset, std::int64_t n_bytes) {
  if (offset < 0 || n_bytes > size_ - offset) return nullptr;
  const auto held = static_cast<std::int64_t>(buffer_.size());
  if (offset < buffer_begin_ || offset + n_bytes > buffer_begin_ + held) {
    const std::int64_t wanted = std::min(size_ - offset, std::max(n_bytes, kReadAheadBytes));
    buffer_.resize(static_cast<std::size_t>(wanted));
    buffer_begin_ = offset;
    std::int64_t got = 0;
    while (got < wanted) {
      const ssize_t n =
          pread(file_, buffer_.data() + got, static_cast<std::size_t>(wanted - got), offset + got);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) break;
      got += n;
    }
    buffer_.resize(static_cast<std::size_t>(got));
    if (got < n_bytes) return nullptr;
  }
  return buffer_.data() + (offset - buffer_begin_);
}

}  // namespace fusion_slam
