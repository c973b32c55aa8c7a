#include "libs/bus/sequence.hpp"

#include <algorithm>

namespace fusion_slam {

SequenceTracker::Seen SequenceTracker::see(std::int64_t seq, std::int64_t utime_us,
                                           std::int64_t now_us) {
  const bool restarted = seq == 1 && highest_ > 1 && missing_.count(1) == 0 && floor_ == 1 &&
                         utime_us > newest_utime_us_;
  if (restarted) {
    highest_ = 0;
    missing_.clear();
    before_floor_.clear();
  }
  newest_utime_us_ = std::max(newest_utime_us_, utime_us);
  if (!joined_) {
    joined_ = true;
    floor_ = seq;
    highest_ = seq;
    return Seen::kNew;
  }
  if (seq < floor_) return before_floor_.insert(seq).second ? Seen::kNew : Seen::kDuplicate;
  if (seq > highest_) {
    expect(seq, now_us);
    missing_.erase(seq);
    return Seen::kNew;
  }
  return missing_.erase(seq) > 0 ? Seen::kNew : Seen::kDuplicate;
}

void SequenceTracker::expect(std::int64_t count, std::int64_t now_us) {
  if (!joined_) return;
  // A forged or absurd number must not make us remember millions of gaps.
  constexpr std::int64_t kMostGaps = 100'000;
  const std::int64_t first = std::max({highest_ + 1, floor_, count - kMostGaps});
  for (std::int64_t seq = first; seq <= count; ++seq) missing_.emplace(seq, now_us);
  highest_ = std::max(highest_, count);
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
  std::size_t lost = 0;
  for (auto it = missing_.begin(); it != missing_.end();) {
    if (now_us - it->second < max_age_us) {
      ++it;
      continue;
    }
    it = missing_.erase(it);
    ++lost;
  }
  return lost;
}

}  // namespace fusion_slam
