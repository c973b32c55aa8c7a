// A set of ids that come mostly one after the other: memory grows with its gaps, not with its size.
// Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>

namespace fusion_slam {

class IdRanges {
 public:
  // False: was there.
  bool insert(std::int64_t id) {
    if (contains(id)) return false;
    ++size_;
    std::int64_t first = id;
    std::int64_t last = id;
    auto next = ranges_.upper_bound(id);
    if (next != ranges_.end() && next->first == id + 1) {
      last = next->second;
      next = ranges_.erase(next);
    }
    if (next != ranges_.begin() && std::prev(next)->second == id - 1) {
      std::prev(next)->second = last;
      return true;
    }
    ranges_.emplace(first, last);
    return true;
  }

  // All ids from `first` to `last`, none of which is in it.
  void insert_range(std::int64_t first, std::int64_t last) {
    if (last < first) return;
    insert(first);
    if (last == first) return;
    auto it = std::prev(ranges_.upper_bound(first));
    it->second = last;
    size_ += static_cast<std::size_t>(last - first);
  }

  bool contains(std::int64_t id) const {
    const auto next = ranges_.upper_bound(id);
    return next != ranges_.begin() && std::prev(next)->second >= id;
  }

  std::size_t size() const { return size_; }
  const std::map<std::int64_t, std::int64_t>& ranges() const { return ranges_; }  // first: last

 private:
  std::map<std::int64_t, std::int64_t> ranges_;
  std::size_t size_ = 0;
};

}  // namespace fusion_slam
