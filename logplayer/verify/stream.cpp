#include "logplayer/verify/stream.hpp"

#include <cstdio>

namespace fusion_slam {

std::string backwards(std::int64_t from_us, std::int64_t to_us) {
  const double from_s = static_cast<double>(from_us) * 1e-6;
  const double to_s = static_cast<double>(to_us) * 1e-6;
  char text[128];
  std::snprintf(text, sizeof text, " by %.6f s, from %.6f to %.6f", from_s - to_s, from_s, to_s);
  return text;
}

void Stream::see(std::int64_t utime_us, std::int64_t offset_bytes) {
  const Message now{utime_us, offset_bytes};
  if (last_) compare(*last_, now);
  last_ = now;
}

void Stream::see(std::int64_t seq, std::int64_t utime_us, std::int64_t offset_bytes) {
  const auto [known, is_new] = by_seq_.emplace(seq, Message{utime_us, offset_bytes});
  if (is_new) return;
  if (known->second.utime_us == utime_us) {
    ++n_resent_;
    return;
  }
  ++n_restarts_;
  close_session();
  by_seq_.emplace(seq, Message{utime_us, offset_bytes});
}

std::vector<Finding> Stream::finish() {
  close_session();
  return std::move(findings_);
}

void Stream::compare(const Message& before, const Message& now) {
  if (!check_time_ || now.utime_us >= before.utime_us) return;
  findings_.push_back(
      {now.offset_bytes, "time",
       name_ + ": measurement time goes back" + backwards(before.utime_us, now.utime_us)});
}

void Stream::close_session() {
  for (auto now = by_seq_.begin(); now != by_seq_.end(); ++now) {
    if (now == by_seq_.begin()) continue;
    const auto before = std::prev(now);
    compare(before->second, now->second);
    // Unsigned: numbers in a log may be anything.
    const std::uint64_t missing =
        static_cast<std::uint64_t>(now->first) - static_cast<std::uint64_t>(before->first) - 1;
    if (missing == 0) continue;
    const std::string first = std::to_string(before->first + 1);
    findings_.push_back(
        {now->second.offset_bytes, "hole",
         name_ + ": " +
             (missing == 1 ? "seq " + first + " is missing"
                           : "seq " + first + " to " + std::to_string(now->first - 1) +
                                 " are missing (" + std::to_string(missing) + " messages)") +
             "; the message before stands at byte " + std::to_string(before->second.offset_bytes)});
  }
  by_seq_.clear();
}

}  // namespace fusion_slam
