// Messages that have arrived and wait for their handler: one queue a channel, a policy each, merged
// by measurement time. Pure data structure: no network, no clock of its own. Not thread-safe (the
// Bus locks around it).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libs/bus/policy.hpp"
#include "libs/bus/sequence.hpp"

namespace fusion_slam {

struct InboxItem {
  std::size_t channel = 0;  // index returned by add_channel
  std::int64_t utime_us = 0;
  std::int64_t seq = 0;  // 0: the type has none; then the order of arrival counts
  std::int64_t arrival_us = 0;
  std::vector<std::uint8_t> bytes;
};

struct InboxCounters {
  std::int64_t received = 0;
  std::int64_t processed = 0;
  std::int64_t dropped = 0;
  std::int64_t lost = 0;
  std::int64_t late = 0;
  std::int64_t duplicated = 0;
  std::int64_t rejected = 0;
  std::int64_t bytes = 0;
  std::int64_t last_utime_us = 0;
};

class Inbox {
 public:
  // In replay modes streams begin at 1, nothing is dropped and identical repeats of messages
  // without seq are duplicates.
  Inbox(Mode mode, std::size_t keep_all_bound, std::int64_t merge_wait_us);

  // has_seq: the type numbers its messages; otherwise the order of arrival counts.
  std::size_t add_channel(const std::string& name, Policy policy, bool has_seq);

  // True when the message waits now; false when it was a duplicate.
  bool push(InboxItem item);

  // Live and throughput: the oldest message (by utime, then channel) that may be handled at now_us:
  // every other channel that has spoken lately has something newer, or it has waited as long as
  // that channel's messages take longer from measurement to arrival than this one did (and a sixth
  // of merge_wait_us for their jitter), at most merge_wait_us. A channel that takes longer than
  // that is not waited for: its messages of this time can't come in time. Nor is one of which only
  // the newest counts.
  std::optional<InboxItem> pop(std::int64_t now_us);

  // Lockstep: true when all messages up to these counts are here (channels not subscribed are
  // ignored).
  bool complete(const std::map<std::string, std::int64_t>& counts) const;
  // Lockstep: whether counts name anything that is not handled yet.
  bool has_work(const std::map<std::string, std::int64_t>& counts) const;
  // Lockstep: takes those messages, in canonical order: utime, channel in order of subscription,
  // sequence.
  std::vector<InboxItem> take(const std::map<std::string, std::int64_t>& counts);

  // The publisher of `channel` has sent `count` messages since it started (replay modes, or as its
  // STATUS says).
  void expect(const std::string& channel, std::int64_t count, std::int64_t now_us);
  // What to ask for again: numbers missing for at least min_age_us, at most `most`. Of a channel
  // without seq nobody can tell which of the latest is missing: all of them, repeats are known.
  std::vector<std::int64_t> missing(std::size_t channel, std::int64_t now_us,
                                    std::int64_t min_age_us, std::size_t most) const;

  void processed(const InboxItem& item);  // counts it as handled to the end
  // It was handled by an earlier process: numbers missing between it and the next are missed.
  void was_handled(std::size_t channel, std::int64_t seq, std::int64_t utime_us,
                   std::int64_t now_us);

  struct Channel {
    std::string name;
    Policy policy = Policy::kKeepAll;
    SequenceTracker sequence{false};
    std::deque<InboxItem> queue;
    std::deque<std::size_t> recent_hashes;  // of messages without seq, replay modes
    InboxCounters counters;
    std::int64_t newest_utime_us = 0;
    std::int64_t newest_arrival_us = 0;
    std::int64_t lag_us =
        0;  // of the latest message: arrival - utime; only differences mean anything
    bool has_seq = false;
    bool awaited = true;  // live: others wait for its messages of their time
    // Of a channel without seq, replay modes:
    std::int64_t expected = 0;  // messages sent, as last heard
    std::int64_t whole = 0;     // all of the first so many have arrived
    bool lacks = false;         // when last heard, not all expected had arrived ...
    std::int64_t lacks_since_us = 0;
  };
  std::vector<Channel>& channels() { return channels_; }
  const std::vector<Channel>& channels() const { return channels_; }
  std::size_t waiting() const;

 private:
  bool is_repeat(Channel& channel, const InboxItem& item) const;
  bool waits_for_repair() const;
  bool may_go(const InboxItem& item, std::int64_t now_us) const;

  Mode mode_;
  std::size_t keep_all_bound_;
  std::int64_t merge_wait_us_;
  std::vector<Channel> channels_;
  std::int64_t handled_utime_us_ = 0;
};

}  // namespace fusion_slam
