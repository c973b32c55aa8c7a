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
    if (current_.file >= 0) close(current_.file);
    throw std::runtime_error("journal " + path_.string() + ": " + why);
  };
  const bool existed = access(path_.c_str(), F_OK) == 0;
  const int fd = current_.file = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) fail(std::strerror(errno));
  if (flock(fd, LOCK_EX | LOCK_NB) != 0)
    fail("another process writes it: does the same service run twice?");
  std::uint8_t head[4] = {};
  const ssize_t n = pread(fd, head, sizeof head, 0);
  if (n == 4 && (head[0] != 0xED || head[1] != 0xA1 || head[2] != 0xDA || head[3] != 0x01))
    fail("this is no LCM log: give another folder");
  current_.state = read_journal(path_, on_record);
  current_.state.existed = existed;
  const std::int64_t whole_bytes = current_.state.whole_bytes;
  if (current_.state.cut_bytes > 0 && ftruncate(fd, whole_bytes) != 0) fail(std::strerror(errno));
  lseek(fd, whole_bytes, SEEK_SET);
  unlink(path_anew().c_str());  // of a process that was killed: this one is whole
}

Journal::~Journal() {
  wait_for_disk();
  if (is_renewed()) take_its_place();
  if (current_.file >= 0) close(current_.file);
}

bool Journal::write_record(std::int64_t timestamp_us, const std::string& channel,
                           const std::uint8_t* bytes, std::size_t size_bytes, File* file) {
  std::vector<std::uint8_t> record;
  record.reserve(static_cast<std::size_t>(kLogHeaderBytes) + channel.size() + size_bytes);
  JournalState& state = file->state;
  put(&record, kLogSync, 4);
  const std::uint32_t crc = checksum(state.n_records, timestamp_us, channel, bytes, size_bytes);
  put(&record, static_cast<std::uint64_t>(event_number(state.n_records, crc)), 8);
  put(&record, static_cast<std::uint64_t>(timestamp_us), 8);
  put(&record, channel.size(), 4);
  put(&record, size_bytes, 4);
  record.insert(record.end(), channel.begin(), channel.end());
  record.insert(record.end(), bytes, bytes + size_bytes);
  std::size_t done = 0;
  while (done < record.size()) {
    const ssize_t n = write(file->file, record.data() + done, record.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      if (ftruncate(file->file, state.whole_bytes) == 0)
        lseek(file->file, state.whole_bytes, SEEK_SET);
      return false;
    }
    done += static_cast<std::size_t>(n);
  }
  ++state.n_records;
  state.whole_bytes += static_cast<std::int64_t>(record.size());
  return true;
}

bool Journal::append(std::int64_t timestamp_us, const std::string& channel,
                     const std::uint8_t* bytes, std::size_t size_bytes) {
  settle();
  if (is_renewed() && !append_anew(timestamp_us, channel, bytes, size_bytes)) abandon_anew();
  return write_record(timestamp_us, channel, bytes, size_bytes, &current_);
}

bool Journal::begin_anew() {
  if (is_renewed()) return false;
  const int fd = open(path_anew().c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return false;
  anew_ = {fd, JournalState{}};
  synced_ = sync_failed_ = false;
  // Held when it takes the old one's place: a second process must find it taken.
  if (flock(fd, LOCK_EX | LOCK_NB) == 0) return true;
  abandon_anew();
  return false;
}

bool Journal::append_anew(std::int64_t timestamp_us, const std::string& channel,
                          const std::uint8_t* bytes, std::size_t size_bytes) {
  return is_renewed() && write_record(timestamp_us, channel, bytes, size_bytes, &anew_);
}

// On a thread of its own, because a disk may take seconds.
bool Journal::finish_anew() {
  if (!is_renewed()) return false;
  wait_for_disk();
  syncing_ = std::thread([this, fd = anew_.file] {
    if (fdatasync(fd) != 0) sync_failed_ = true;
    synced_ = true;
  });
  return true;
}

void Journal::settle() {
  if (is_renewed() && synced_) take_its_place();
}

void Journal::wait_for_disk() {
  if (syncing_.joinable()) syncing_.join();
}

void Journal::take_its_place() {
  wait_for_disk();
  if (!synced_ || sync_failed_ || rename(path_anew().c_str(), path_.c_str()) != 0)
    return abandon_anew();
  close(current_.file);
  current_ = anew_;
  current_.state.existed = true;
  anew_ = {};
}

void Journal::abandon_anew() {
  wait_for_disk();
  if (anew_.file >= 0) close(anew_.file);
  anew_ = {};
  unlink(path_anew().c_str());
}

std::optional<LogEvent> Journal::record_at(std::int64_t offset_bytes, std::int64_t number) const {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(kLogHeaderBytes));
  const auto read_all = [&](std::uint8_t* to, std::size_t size, std::int64_t from) {
    while (size > 0) {
      const ssize_t n = pread(current_.file, to, size, from);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      to += n;
      from += n;
      size -= static_cast<std::size_t>(n);
    }
    return true;
  };
  if (!read_all(bytes.data(), bytes.size(), offset_bytes)) return std::nullopt;
  const std::int64_t channel_bytes = get(bytes.data() + 20, 4);
  const std::int64_t data_bytes = get(bytes.data() + 24, 4);
  if (get(bytes.data(), 4) != kLogSync || channel_bytes > kMaxLogChannelBytes ||
      data_bytes > current_.state.whole_bytes - offset_bytes)
    return std::nullopt;
  LogEvent event;
  event.offset_bytes = offset_bytes;
  event.number = get(bytes.data() + 4, 8);
  event.timestamp_us = get(bytes.data() + 12, 8);
  bytes.resize(static_cast<std::size_t>(channel_bytes));
  event.data.resize(static_cast<std::size_t>(data_bytes));
  const std::int64_t at = offset_bytes + kLogHeaderBytes;
  if (!read_all(bytes.data(), bytes.size(), at) ||
      !read_all(event.data.data(), event.data.size(), at + channel_bytes))
    return std::nullopt;
  event.channel.assign(bytes.begin(), bytes.end());
  if (!is_whole(event, number)) return std::nullopt;
  return event;
}

bool Journal::sync() { return fdatasync(current_.file) == 0; }

}  // namespace fusion_slam
