#include "libs/bus/inbox.hpp"

#include <algorithm>
#include <string_view>
#include <tuple>
#include <utility>

namespace fusion_slam {
namespace {

constexpr std::size_t kRepeatMemory = 256;  // as the replay's (logplayer/replay/conductor.cpp)
// A channel that has been silent for longer than this is not waited for.
constexpr std::int64_t kSilent_us = 500'000;

constexpr std::int64_t kJitterPart = 6;  // of merge_wait_us: how much a channel's lag may vary

std::int64_t count_for(const std::map<std::string, std::int64_t>& counts,
                       const std::string& channel) {
  const auto it = counts.find(channel);
  return it == counts.end() ? 0 : it->second;
}

}  // namespace

Inbox::Inbox(Mode mode, std::size_t keep_all_bound, std::int64_t merge_wait_us)
    : mode_(mode), keep_all_bound_(keep_all_bound), merge_wait_us_(merge_wait_us) {}

std::size_t Inbox::add_channel(const std::string& name, Policy policy, bool has_seq) {
  Channel channel;
  channel.name = name;
  channel.has_seq = has_seq;
  channel.policy = mode_ == Mode::kLive ? policy : Policy::kKeepAll;
  channel.awaited = policy == Policy::kKeepAll;
  channel.sequence = SequenceTracker(mode_ != Mode::kLive);
  channels_.push_back(std::move(channel));
  return channels_.size() - 1;
}

bool Inbox::is_repeat(Channel& channel, const InboxItem& item) const {
  if (mode_ == Mode::kLive) return false;
  const std::size_t hash = std::hash<std::string_view>()(
      {reinterpret_cast<const char*>(item.bytes.data()), item.bytes.size()});
  auto& recent = channel.recent_hashes;
  if (std::find(recent.begin(), recent.end(), hash) != recent.end()) return true;
  recent.push_back(hash);
  if (recent.size() > kRepeatMemory) recent.pop_front();
  return false;
}

bool Inbox::push(InboxItem item) {
  Channel& channel = channels_[item.channel];
  const bool duplicate = channel.has_seq
                             ? channel.sequence.see(item.seq, item.utime_us, item.arrival_us) ==
                                   SequenceTracker::Seen::kDuplicate
                             : is_repeat(channel, item);
  if (duplicate) {
    ++channel.counters.duplicated;
    return false;
  }
  // Nobody waits for what a newer one has taken the place of.
  if (channel.has_seq && mode_ == Mode::kLive && channel.policy == Policy::kLatestOnly)
    channel.sequence.never_given(0, item.seq);
  InboxCounters& counters = channel.counters;
  ++counters.received;
  counters.bytes += static_cast<std::int64_t>(item.bytes.size());
  channel.newest_utime_us = std::max(channel.newest_utime_us, item.utime_us);
  channel.newest_arrival_us = item.arrival_us;
  channel.lag_us = item.arrival_us - item.utime_us;
  if (!channel.has_seq) item.seq = counters.received;
  if (channel.policy == Policy::kLatestOnly) {
    counters.dropped += static_cast<std::int64_t>(channel.queue.size());
    channel.queue.clear();
  } else if (mode_ == Mode::kLive && channel.queue.size() >= keep_all_bound_) {
    channel.queue.pop_front();
    ++counters.dropped;
  }
  // A re-sent message goes back to its place; without a number of its own its time tells where that
  // is.
  const bool by_time = !channel.has_seq && mode_ == Mode::kThroughput;
  const auto behind = [&](const InboxItem& other) {
    return by_time ? other.utime_us > item.utime_us : other.seq > item.seq;
  };
  auto place = channel.queue.end();
  while (place != channel.queue.begin() && behind(*std::prev(place))) --place;
  channel.queue.insert(place, std::move(item));
  return true;
}

bool Inbox::may_go(const InboxItem& item, std::int64_t now_us) const {
  if (mode_ == Mode::kThroughput || now_us - item.arrival_us >= merge_wait_us_) return true;
  const std::int64_t waited_us = now_us - item.arrival_us;
  for (const Channel& other : channels_) {
    const bool speaks = now_us - other.newest_arrival_us < kSilent_us && other.newest_utime_us > 0;
    if (!other.awaited || !speaks || other.newest_utime_us >= item.utime_us) continue;
    // When its message of the same time would be here, counted from this one's arrival.
    const std::int64_t later_us = other.lag_us - (item.arrival_us - item.utime_us);
    if (later_us <= merge_wait_us_ && waited_us < later_us + merge_wait_us_ / kJitterPart)
      return false;
  }
  return true;
}

// Throughput: something is on its way again, perhaps older than all that waits here (a camera's
// model before its frames).
bool Inbox::waits_for_repair() const {
  if (mode_ != Mode::kThroughput) return false;
  return std::any_of(channels_.begin(), channels_.end(), [](const Channel& channel) {
    return channel.has_seq ? channel.sequence.missing_count() > 0
                           : channel.lacks && channel.counters.received < channel.expected;
  });
}

std::optional<InboxItem> Inbox::pop(std::int64_t now_us) {
  if (waits_for_repair()) return std::nullopt;
  Channel* best = nullptr;
  for (Channel& channel : channels_) {
    if (channel.queue.empty()) continue;
    if (best == nullptr || channel.queue.front().utime_us < best->queue.front().utime_us)
      best = &channel;
  }
  if (best == nullptr || !may_go(best->queue.front(), now_us)) return std::nullopt;
  InboxItem item = std::move(best->queue.front());
  best->queue.pop_front();
  if (item.utime_us < handled_utime_us_) ++best->counters.late;
  handled_utime_us_ = std::max(handled_utime_us_, item.utime_us);
  return item;
}

bool Inbox::complete(const std::map<std::string, std::int64_t>& counts) const {
  for (const Channel& channel : channels_) {
    const std::int64_t count = count_for(counts, channel.name);
    if (channel.counters.received < count) return false;
    const auto lowest = channel.sequence.missing(INT64_MAX, 0, 1);
    if (!lowest.empty() && lowest.front() <= count) return false;
  }
  return true;
}

bool Inbox::has_work(const std::map<std::string, std::int64_t>& counts) const {
  for (const Channel& channel : channels_)
    if (channel.counters.processed < count_for(counts, channel.name)) return true;
  return false;
}

std::vector<InboxItem> Inbox::take(const std::map<std::string, std::int64_t>& counts) {
  std::vector<InboxItem> items;
  for (Channel& channel : channels_) {
    const std::int64_t count = count_for(counts, channel.name);
    while (!channel.queue.empty() && channel.queue.front().seq <= count) {
      items.push_back(std::move(channel.queue.front()));
      channel.queue.pop_front();
    }
  }
  std::sort(items.begin(), items.end(), [](const InboxItem& a, const InboxItem& b) {
    return std::tie(a.utime_us, a.channel, a.seq) < std::tie(b.utime_us, b.channel, b.seq);
  });
  return items;
}

void Inbox::expect(const std::string& name, std::int64_t count, std::int64_t now_us) {
  for (Channel& channel : channels_) {
    if (channel.name != name) continue;
    if (channel.has_seq) {
      channel.sequence.expect(count, now_us);
      continue;
    }
    if (count < channel.expected) continue;
    channel.expected = count;
    const bool lacked = channel.lacks;
    channel.lacks = channel.counters.received < count;
    if (!channel.lacks) channel.whole = count;
    if (channel.lacks && !lacked) channel.lacks_since_us = now_us;
  }
}

std::vector<std::int64_t> Inbox::missing(std::size_t index, std::int64_t now_us,
                                         std::int64_t min_age_us, std::size_t most) const {
  const Channel& channel = channels_[index];
  if (channel.has_seq) return channel.sequence.missing(now_us, min_age_us, most);
  std::vector<std::int64_t> result;
  const bool lacks = channel.lacks && channel.counters.received < channel.expected;
  if (mode_ == Mode::kLive || !lacks || now_us - channel.lacks_since_us < min_age_us) return result;
  for (std::int64_t n = channel.whole + 1; n <= channel.expected && result.size() < most; ++n)
    result.push_back(n);
  return result;
}

void Inbox::was_handled(std::size_t channel, std::int64_t seq, std::int64_t utime_us,
                        std::int64_t now_us) {
  Channel& heard = channels_[channel];
  if (!heard.has_seq || seq <= 0) return;
  heard.sequence.was_handled(seq, utime_us, now_us);
  if (mode_ == Mode::kLive && heard.policy == Policy::kLatestOnly)
    heard.sequence.never_given(0, heard.sequence.highest());
}

void Inbox::processed(const InboxItem& item) {
  InboxCounters& counters = channels_[item.channel].counters;
  ++counters.processed;
  counters.last_utime_us = item.utime_us;
}

std::size_t Inbox::waiting() const {
  std::size_t n = 0;
  for (const Channel& channel : channels_) n += channel.queue.size();
  return n;
}

}  // namespace fusion_slam
