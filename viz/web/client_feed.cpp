#include "viz/web/client_feed.hpp"

#include "viz/web/protocol.hpp"

namespace fusion_slam {

std::optional<std::string> ClientFeed::next(std::int64_t now_us) {
  if (wanted_.none() || under_way() >= kMostUnderWay) return std::nullopt;
  if (!was_full_ && last_us_ && now_us - *last_us_ < kPeriod_us) return std::nullopt;
  const std::uint64_t epoch = cursor_.epoch;
  const auto items = store_.next(&cursor_, wanted_, kBatchBytes);
  if (items.empty() && cursor_.epoch == epoch) return was_full_ = false, std::nullopt;
  std::string batch = encode_batch(++sent_, cursor_.epoch, items);
  was_full_ = batch.size() >= kBatchBytes;
  last_us_ = now_us;
  bytes_sent_ += batch.size();
  return batch;
}

void ClientFeed::acknowledge(std::uint32_t batch) {
  if (batch > acknowledged_ && batch <= sent_) acknowledged_ = batch;
}

// While a topic is not wanted the browser's copy of it ages, so it starts anew.
void ClientFeed::want(const TopicSet& topics) {
  for (std::size_t topic = 0; topic < kTopics; ++topic)
    if (topics[topic] && !wanted_[topic]) ItemStore::rewind(&cursor_, static_cast<Topic>(topic));
  wanted_ = topics;
}

}  // namespace fusion_slam
