#include "libs/bus/sequence.hpp"

#include <algorithm>
#include <utility>

namespace fusion_slam {

SequenceTracker::Seen SequenceTracker::see(std::int64_t seq, std::int64_t utime_us,
                                           std::int64_t now_us) {
  // A repeat is never newer than the newest: this one is of a publisher that was started again.
  if (joined_ && was_seen(seq) && utime_us > newest_utime_us_) {
    floor_ = seq;
    highest_ = seq - 1;
    missing_.clear();
    given_up_.clear();
    before_floor_.erase(before_floor_.lower_bound(seq), before_floor_.end());
  }
  newest_utime_us_ = std::max(newest_utime_us_, utime_us);
  if (!joined_) {
    joined_ = true;
    told_ = published_before_ > 0;
    floor_ = seq;
    highest_ = seq;
    // So far behind it was sent again, because somebody asked: what lies between was sent before
    // this listener was here. A nearer one may have been on its way while the number was.
    if (seq > published_before_ - kOnTheWay) return Seen::kNew;
    highest_ = published_before_;
    floor_ = highest_ + 1;
  }
  if (seq < floor_) return before_floor_.insert(seq).second ? Seen::kNew : Seen::kDuplicate;
  if (seq > highest_) {
    note_gaps(seq, now_us);
    missing_.erase(seq);
    return Seen::kNew;
  }
  return missing_.erase(seq) + given_up_.erase(seq) > 0 ? Seen::kNew : Seen::kDuplicate;
}

void SequenceTracker::was_handled(std::int64_t seq, std::int64_t utime_us, std::int64_t now_us) {
  // Of a publisher that has been started again since: the number is far ahead of newer ones.
  if (joined_ && seq > highest_ + kOnTheWay && utime_us < newest_utime_us_) return;
  if (joined_ && seq < floor_ && utime_us > newest_utime_us_) restart();  // and this one's is not
  if (joined_ && seq < floor_) {
    for (std::int64_t gap = std::max(seq + 1, floor_ - kMostGaps); gap < floor_; ++gap)
      if (before_floor_.count(gap) == 0) missing_.emplace(gap, now_us);
    before_floor_.erase(before_floor_.lower_bound(seq), before_floor_.end());
    floor_ = seq;
  } else {
    see(seq, utime_us, now_us);
  }
  told_ = true;
}

void SequenceTracker::restart() {
  joined_ = false;
  told_ = false;
  floor_ = 1;
  highest_ = 0;
  published_before_ = 0;
  missing_.clear();
  given_up_.clear();
  before_floor_.clear();
}

bool SequenceTracker::was_seen(std::int64_t seq) const {
  if (seq < floor_) return before_floor_.count(seq) > 0;
  return seq <= highest_ && missing_.count(seq) + given_up_.count(seq) == 0;
}

void SequenceTracker::expect(std::int64_t count, std::int64_t now_us) {
  if (!joined_) {
    published_before_ = std::clamp<std::int64_t>(count, 0, INT64_MAX - 1);
    return;
  }
  if (!std::exchange(told_, true) && count > kOnTheWay && floor_ <= count - kOnTheWay)
    join_behind(std::min(count, INT64_MAX - 1));
  note_gaps(count, now_us);
}

// What came until now was sent again, for somebody: only now the publisher says how far it is.
void SequenceTracker::join_behind(std::int64_t count) {
  const std::int64_t last = std::min(highest_, count);
  for (std::int64_t n = 0; n < std::min(last - floor_ + 1, kMostGaps); ++n)
    if (was_seen(last - n)) before_floor_.insert(last - n);
  missing_.erase(missing_.begin(), missing_.upper_bound(count));
  floor_ = count + 1;
  highest_ = std::max(highest_, count);
}

void SequenceTracker::note_gaps(std::int64_t count, std::int64_t now_us) {
  if (count <= highest_) return;
  // Forged or absurd numbers must not make us remember millions of gaps.
  const std::int64_t first = std::max({highest_ + 1, floor_, count - kMostGaps});
  for (std::int64_t gap = 0; gap <= count - first; ++gap) missing_.emplace(first + gap, now_us);
  while (missing_.size() > static_cast<std::size_t>(kMostGaps)) {
    missing_.erase(missing_.begin());
    ++forgotten_;
  }
  highest_ = count;
}

void SequenceTracker::never_given(std::int64_t first, std::int64_t last) {
  if (first > last) return;
  missing_.erase(missing_.lower_bound(first), missing_.upper_bound(last));
}

std::vector<std::int64_t> SequenceTracker::missing(std::int64_t now_us, std::int64_t min_age_us,
                                                   std::size_t most) const {
  std::vector<std::int64_t> result;
  for (const auto& [seq, since_us] : missing_) {
    if (result.size() >= most) break;
    if (now_us - since_us >= min_age_us) result.push_back(seq);
  }
  return result;
}

std::size_t SequenceTracker::give_up(std::int64_t now_us, std::int64_t max_age_us) {
  std::size_t lost = std::exchange(forgotten_, 0);
  for (auto it = missing_.begin(); it != missing_.end();) {
    if (now_us - it->second < max_age_us) {
      ++it;
      continue;
    }
    given_up_.insert(it->first);
    it = missing_.erase(it);
    ++lost;
  }
  while (given_up_.size() > static_cast<std::size_t>(kMostGaps)) given_up_.erase(given_up_.begin());
  return lost;
}

}  // namespace fusion_slam
