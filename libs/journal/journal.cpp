#include "libs/journal/journal.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

namespace fusion_slam {
namespace {

void put(std::vector<std::uint8_t>* out, std::uint64_t value, int n_bytes) {
  for (int i = n_bytes - 1; i >= 0; --i)
    out->push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

// Everything that counts: the record's place, time, channel and bytes.
std::uint32_t checksum(std::int64_t number, std::int64_t timestamp_us, const std::string& channel,
                       const std::uint8_t* bytes, std::size_t size_bytes) {
  std::vector<std::uint8_t> head;
  put(&head, static_cast<std::uint64_t>(number), 8);
  put(&head, static_cast<std::uint64_t>(timestamp_us), 8);
  head.insert(head.end(), channel.begin(), channel.end());
  head.push_back(0);
  uLong crc = crc32(0L, head.data(), static_cast<uInt>(head.size()));
  // crc32() begins anew when it is given no address, as an empty vector has.
  if (size_bytes > 0) crc = crc32(crc, bytes, static_cast<uInt>(size_bytes));
  return static_cast<std::uint32_t>(crc);
}

// Bits 62..31: CRC-32; bits 30..0: the record's number, from 0. Never negative.
std::int64_t event_number(std::int64_t number, std::uint32_t crc) {
  return static_cast<std::int64_t>((static_cast<std::uint64_t>(crc) << 31U) |
                                   (static_cast<std::uint64_t>(number) & 0x7fffffffU));
}

std::int64_t get(const std::uint8_t* bytes, int n_bytes) {
  std::uint64_t value = 0;
  for (int i = 0; i < n_bytes; ++i) value = (value << 8U) | bytes[i];
  return static_cast<std::int64_t>(value);
}

// Not LogReader: that wants a sync word behind an event, and so would give up the record before a
// damaged one, too.
bool read_record(std::istream& in, std::int64_t left_bytes, LogEvent* event) {
  std::uint8_t head[kLogHeaderBytes];
  if (left_bytes < kLogHeaderBytes || !in.read(reinterpret_cast<char*>(head), sizeof head))
    return false;
  const std::int64_t channel_bytes = get(head + 20, 4);
  const std::int64_t data_bytes = get(head + 24, 4);
  if (get(head, 4) != kLogSync || channel_bytes > kMaxLogChannelBytes ||
      data_bytes > left_bytes - kLogHeaderBytes - channel_bytes)
    return false;
  event->number = get(head + 4, 8);
  event->timestamp_us = get(head + 12, 8);
  event->channel.resize(static_cast<std::size_t>(channel_bytes));
  event->data.resize(static_cast<std::size_t>(data_bytes));
  in.read(event->channel.data(), channel_bytes);
  in.read(reinterpret_cast<char*>(event->data.data()), data_bytes);
  return static_cast<bool>(in);
}

bool is_whole(const LogEvent& event, std::int64_t number) {
  return event.number == event_number(number, checksum(number, event.timestamp_us, event.channel,
                                                       event.data.data(), event.data.size()));
}

}  // namespace

JournalState read_journal(const std::filesystem::path& file,
                          const std::function<void(const LogEvent&)>& on_record) {
  JournalState state;
  std::error_code problem;
  const auto size = std::filesystem::file_size(file, problem);
  if (problem) return state;
  state.existed = true;
  const auto size_bytes = static_cast<std::int64_t>(size);
  std::ifstream in(file, std::ios::binary);
  LogEvent event;
  while (read_record(in, size_bytes - state.whole_bytes, &event) &&
         is_whole(event, state.n_records)) {
    event.offset_bytes = state.whole_bytes;
    if (on_record) on_record(event);
    ++state.n_records;
    state.whole_bytes += kLogHeaderBytes + static_cast<std::int64_t>(event.channel.size()) +
                         static_cast<std::int64_t>(event.data.size());
  }
  state.cut_bytes = size_bytes - state.whole_bytes;
  return state;
}

Journal::Journal(const std::filesystem::path& file,
                 const std::function<void(const LogEvent&)>& on_record)
    : path_(file) {
  const auto fail = [&](const std::string& why) {
    if (file_ >= 0) close(file_);
    throw std::runtime_error("journal " + path_.string() + ": " + why);
  };
  const bool existed = access(path_.c_str(), F_OK) == 0;
  file_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) fail(std::strerror(errno));
  if (flock(file_, LOCK_EX | LOCK_NB) != 0)
    fail("another process writes it: does the same service run twice?");
  std::uint8_t head[4] = {};
  const ssize_t n = pread(file_, head, sizeof head, 0);
  if (n == 4 && (head[0] != 0xED || head[1] != 0xA1 || head[2] != 0xDA || head[3] != 0x01))
    fail("this is no LCM log: give another folder");
  state_ = read_journal(path_, on_record);
  state_.existed = existed;
  if (state_.cut_bytes > 0 && ftruncate(file_, state_.whole_bytes) != 0) fail(std::strerror(errno));
  lseek(file_, state_.whole_bytes, SEEK_SET);
}

Journal::~Journal() {
  if (file_ >= 0) close(file_);
}

bool Journal::append(std::int64_t timestamp_us, const std::string& channel,
                     const std::uint8_t* bytes, std::size_t size_bytes) {
  std::vector<std::uint8_t> record;
  record.reserve(static_cast<std::size_t>(kLogHeaderBytes) + channel.size() + size_bytes);
  put(&record, kLogSync, 4);
  const std::uint32_t crc = checksum(state_.n_records, timestamp_us, channel, bytes, size_bytes);
  put(&record, static_cast<std::uint64_t>(event_number(state_.n_records, crc)), 8);
  put(&record, static_cast<std::uint64_t>(timestamp_us), 8);
  put(&record, channel.size(), 4);
  put(&record, size_bytes, 4);
  record.insert(record.end(), channel.begin(), channel.end());
  record.insert(record.end(), bytes, bytes + size_bytes);
  std::size_t done = 0;
  while (done < record.size()) {
    const ssize_t n = write(file_, record.data() + done, record.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      if (ftruncate(file_, state_.whole_bytes) == 0) lseek(file_, state_.whole_bytes, SEEK_SET);
      return false;
    }
    done += static_cast<std::size_t>(n);
  }
  ++state_.n_records;
  state_.whole_bytes += static_cast<std::int64_t>(record.size());
  return true;
}

bool Journal::sync() { return fdatasync(file_) == 0; }

}  // namespace fusion_slam
