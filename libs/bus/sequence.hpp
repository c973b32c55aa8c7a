// Which sequence numbers of a channel have arrived. Pure bookkeeping: no clock, no network. Not
// thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

namespace fusion_slam {

class SequenceTracker {
 public:
  enum class Seen { kNew, kDuplicate };

  // from_start: the stream is known to begin at 1 (replay), so 1 is missing until it arrives.
  // Otherwise the first number that arrives is where this listener joined, and nothing before it is
  // missing; nor is what the publisher is known to have sent by then, or first says that it had
  // sent (expect()): the first to arrive may be sent again, long after its turn.
  explicit SequenceTracker(bool from_start) : joined_(from_start), told_(from_start), floor_(1) {}

  // A message with number seq (>= 1), measured at utime_us, arrived at now_us (any monotonic
  // clock). A number that was seen before with a newer measurement than all others begins a new
  // stream: its publisher was started again.
  Seen see(std::int64_t seq, std::int64_t utime_us, std::int64_t now_us);

  // An earlier process of this listener has handled number seq: the stream is joined there, and
  // what lies between it and what has come since is missing.
  void was_handled(std::int64_t seq, std::int64_t utime_us, std::int64_t now_us);

  // The publisher was started again and counts anew: what comes next is where this listener joins.
  void restart();

  // The publisher has sent `count` messages: those not seen are missing from now on, unless this
  // listener hasn't joined yet.
  void expect(std::int64_t count, std::int64_t now_us);

  // The publisher says that these numbers were never given: nobody waits for them.
  void never_given(std::int64_t first, std::int64_t last);

  // Missing numbers whose gap is at least min_age_us old, lowest first, at most `most`.
  std::vector<std::int64_t> missing(std::int64_t now_us, std::int64_t min_age_us,
                                    std::size_t most) const;
  // Stops waiting for numbers missing for longer than max_age_us and says how many. Should one come
  // all the same (a tile that was asked for by its key), it is new.
  std::size_t give_up(std::int64_t now_us, std::int64_t max_age_us);
  std::size_t missing_count() const { return missing_.size(); }

  static constexpr std::int64_t kOnTheWay = 256;  // messages between a publisher and its listener
  static constexpr std::int64_t kMostGaps = 100'000;  // remembered at a time; more are lost at once

  std::int64_t highest() const { return highest_; }

 private:
  bool was_seen(std::int64_t seq) const;
  void join_behind(std::int64_t count);
  void note_gaps(std::int64_t count, std::int64_t now_us);

  bool joined_;
  bool told_;                          // by the publisher, how far it is
  std::int64_t floor_;                 // first number of this listener's stream
  std::int64_t highest_ = 0;           // newest seen or expected
  std::int64_t published_before_ = 0;  // as told before this listener joined
  std::int64_t newest_utime_us_ = 0;
  std::map<std::int64_t, std::int64_t> missing_;  // number -> when the gap was noticed
  std::set<std::int64_t> given_up_;
  std::size_t forgotten_ = 0;            // gaps beyond kMostGaps
  std::set<std::int64_t> before_floor_;  // came to this late listener
};

}  // namespace fusion_slam
