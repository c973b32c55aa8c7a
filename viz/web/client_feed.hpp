// What goes to one browser next. At most two batches are under way: the browser acknowledges each
// when it has drawn it, so one that is slow, asleep or gone receives nothing more, and gets the
// newest state when it wakes. Pure: the caller brings the time. Not thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "viz/web/item_store.hpp"

namespace fusion_slam {

class ClientFeed {
 public:
  static constexpr std::uint32_t kMostUnderWay = 2;
  static constexpr std::size_t kBatchBytes = 256 * 1024;  // about; one item may be larger
  static constexpr std::int64_t kPeriod_us =
      33'000;  // between batches, when the last one was not full

  explicit ClientFeed(const ItemStore& store) : store_(store) {}

  // The next batch, when there is something new and it may be sent now (any monotonic clock).
  std::optional<std::string> next(std::int64_t now_us);
  // All batches up to this number have been drawn. Numbers that were never sent are ignored.
  void acknowledge(std::uint32_t batch);
  // Only these topics from now on; none until then. What was left out and is wanted again is sent
  // whole.
  void want(const TopicSet& topics);

  std::uint32_t under_way() const { return sent_ - acknowledged_; }
  std::uint64_t bytes_sent() const { return bytes_sent_; }

 private:
  const ItemStore& store_;
  Cursor cursor_;
  TopicSet wanted_;
  std::uint32_t sent_ = 0;
  std::uint32_t acknowledged_ = 0;
  std::optional<std::int64_t> last_us_;
  bool was_full_ = false;
  std::uint64_t bytes_sent_ = 0;
};

}  // namespace fusion_slam
