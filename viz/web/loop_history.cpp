#include "viz/web/loop_history.hpp"

#include <algorithm>

#include "fusion_slam/resend_t.hpp"

namespace fusion_slam {
namespace {

const char* const kChannel = "LOOP_CANDIDATE";
constexpr std::int64_t kPerRequest = 1000;

}  // namespace

void LoopHistory::hear(const status_t& status, Bus& bus) {
  std::int64_t published = 0;
  for (const channel_stats_t& channel : status.channels)
    if (channel.channel == kChannel) published = channel.published;
  if (published == 0) return;
  int& tries = tries_[{status.process, status.pid}];
  const auto processed = bus.processed();
  const auto here = processed.find(kChannel);
  const std::int64_t have = here == processed.end() ? 0 : here->second;
  if (tries >= kTries || have >= std::min(published, kMost)) {
    tries = kTries;  // from now on the bus itself sees what is missing
    return;
  }
  ++tries;
  for (std::int64_t first = std::max<std::int64_t>(1, published - kMost + 1); first <= published;
       first += kPerRequest) {
    resend_t request{};
    request.requester = "viewer";
    request.channel = kChannel;
    for (std::int64_t seq = first; seq <= std::min(published, first + kPerRequest - 1); ++seq)
      request.seqs.push_back(seq);
    request.n_seqs = static_cast<std::int32_t>(request.seqs.size());
    bus.publish("RESEND", std::move(request));
  }
}

}  // namespace fusion_slam
