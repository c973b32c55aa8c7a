// The messages of one publisher on one channel: are all there, and does their time go forward?
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace fusion_slam {

struct Finding {
  std::int64_t offset_bytes = 0;  // of the event in the log
  std::string kind;               // hole, time, log_time, undecodable, damage
  std::string text;               // for people, with channel and place
};

class Stream {
 public:
  // check_time: utime has to go forward (not so for tiles: each carries the time of its own newest
  // measurement).
  Stream(std::string name, bool check_time) : name_(std::move(name)), check_time_(check_time) {}

  // A message without a sequence number: compared with the one before it.
  void see(std::int64_t utime_us, std::int64_t offset_bytes);

  // One with a number. Re-sent messages may come late and twice: judged in the order of their
  // numbers, by finish(). The same number with another utime: the publisher was started again.
  void see(std::int64_t seq, std::int64_t utime_us, std::int64_t offset_bytes);

  // What was found, in no special order. Call once, at the end.
  std::vector<Finding> finish();

  std::int64_t n_resent() const { return n_resent_; }
  std::int64_t n_restarts() const { return n_restarts_; }

 private:
  struct Message {
    std::int64_t utime_us = 0;
    std::int64_t offset_bytes = 0;
  };
  void compare(const Message& before, const Message& now);
  void close_session();

  std::string name_;
  bool check_time_;
  std::optional<Message> last_;             // without numbers
  std::map<std::int64_t, Message> by_seq_;  // since the publisher was started
  std::vector<Finding> findings_;
  std::int64_t n_resent_ = 0;
  std::int64_t n_restarts_ = 0;
};

// " by 0.100000 s, from 12.300000 to 12.200000"
std::string backwards(std::int64_t from_us, std::int64_t to_us);

}  // namespace fusion_slam
