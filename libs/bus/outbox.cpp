#include "libs/bus/outbox.hpp"

#include <algorithm>

namespace fusion_slam {
namespace {

// Enough for the gaps that a burst loses; what is older is asked for as tiles or found in the
// journal.
constexpr std::size_t kRecentMessages = 4096;
constexpr std::size_t kRecentBytes = 16 << 20;
constexpr std::int32_t kIndexEntries = 1500;  // 28 bytes each: below 60 KB

}  // namespace

std::int64_t Outbox::next_seq(const std::string& channel) const {
  const auto it = channels_.find(channel);
  return it == channels_.end() ? 1 : it->second.count + 1;
}

void Outbox::sent(const std::string& name, const Bytes& bytes) {
  Channel& channel = channels_[name];
  ++channel.count;
  channel.bytes += static_cast<std::int64_t>(bytes.size());
  channel.recent.emplace_back(channel.count, bytes);
  channel.recent_bytes += bytes.size();
  while (channel.recent.size() > kRecentMessages ||
         (channel.recent_bytes > kRecentBytes && channel.recent.size() > 1)) {
    channel.recent_bytes -= channel.recent.front().second.size();
    channel.recent.pop_front();
  }
}

void Outbox::sent_tile(const std::string& channel, const TileKey& key, std::int64_t revision,
                       const Bytes& bytes) {
  sent(channel, bytes);
  channels_[channel].tiles[key] = {revision, bytes};
}

void Outbox::skip_to(const std::string& name, std::int64_t last) {
  Channel& channel = channels_[name];
  if (last <= channel.count) return;
  channel.never_given[last] = channel.count + 1;
  channel.count = last;
}

const Outbox::Recent& Outbox::recent(const std::string& name) { return channels_[name].recent; }

std::map<std::int64_t, std::int64_t> Outbox::never_given(const std::string& name,
                                                         std::int64_t last) {
  const auto& all = channels_[name].never_given;
  return {all.begin(), all.upper_bound(last)};
}

void Outbox::was_given(const std::string& name, std::int64_t last,
                       const std::map<std::int64_t, std::int64_t>& never_given) {
  Channel& channel = channels_[name];
  channel.count = std::max(channel.count, last);
  channel.never_given.insert(never_given.begin(), never_given.end());
}

void Outbox::forget(const std::string& name) {
  Channel& channel = channels_[name];
  channel.recent.clear();
  channel.recent_bytes = 0;
}

std::vector<Outbox::Bytes> Outbox::tiles(const std::string& name) const {
  std::vector<Bytes> result;
  const auto channel = channels_.find(name);
  if (channel == channels_.end()) return result;
  for (const auto& [key, tile] : channel->second.tiles) result.push_back(tile.bytes);
  return result;
}

void Outbox::sent_once(const std::string& name, std::size_t size_bytes) {
  Channel& channel = channels_[name];
  ++channel.count;
  channel.bytes += static_cast<std::int64_t>(size_bytes);
}

const Outbox::Bytes* Outbox::find(const Wanted& wanted) const {
  const auto& [name, seq, key] = wanted;
  const auto it = channels_.find(name);
  if (it == channels_.end()) return nullptr;
  const Channel& channel = it->second;
  if (seq == 0) {
    const auto tile = channel.tiles.find(key);
    return tile == channel.tiles.end() ? nullptr : &tile->second.bytes;
  }
  const auto at = std::lower_bound(channel.recent.begin(), channel.recent.end(), seq,
                                   [](const auto& sent, std::int64_t n) { return sent.first < n; });
  return at == channel.recent.end() || at->first != seq ? nullptr : &at->second;
}

void Outbox::request(const resend_t& request) {
  const auto note = [this](const Wanted& wanted) {
    if (find(wanted) != nullptr && is_wanted_.insert(wanted).second) wanted_.push_back(wanted);
  };
  const auto channel = channels_.find(request.channel);
  if (channel == channels_.end()) return;
  for (const std::int64_t seq : request.seqs) {
    if (seq <= 0) continue;
    const auto hole = channel->second.never_given.lower_bound(seq);
    if (hole != channel->second.never_given.end() && seq >= hole->second)
      never_given_[request.channel].insert(hole->first);
    else
      note({request.channel, seq, TileKey{}});
  }
  for (std::size_t i = 0; i < request.submap_id.size(); ++i)
    note({request.channel, 0,
          TileKey{request.submap_id[i], request.x[i], request.y[i], request.z[i]}});
}

std::vector<resend_t> Outbox::take_never_given() {
  std::vector<resend_t> result;
  for (const auto& [name, ranges] : std::exchange(never_given_, {})) {
    resend_t told{};
    told.channel = name;
    for (const std::int64_t last : ranges) {
      told.seqs.push_back(-channels_[name].never_given.at(last));
      told.seqs.push_back(-last);
    }
    told.n_seqs = static_cast<std::int32_t>(told.seqs.size());
    result.push_back(std::move(told));
  }
  return result;
}

std::optional<std::pair<std::string, Outbox::Bytes>> Outbox::take_requested() {
  while (!wanted_.empty()) {
    const Wanted wanted = std::move(wanted_.front());
    wanted_.pop_front();
    is_wanted_.erase(wanted);
    if (const Bytes* bytes = find(wanted)) return std::pair{std::get<0>(wanted), *bytes};
  }
  return std::nullopt;
}

std::vector<tile_index_t> Outbox::indexes() const {
  std::vector<tile_index_t> result;
  for (const auto& [name, channel] : channels_) {
    if (channel.tiles.empty()) continue;
    const std::size_t first = result.size();
    for (const auto& [key, tile] : channel.tiles) {
      if (result.size() == first || result.back().n == kIndexEntries) {
        result.emplace_back();
        result.back().utime = 0;
        result.back().seq = 0;
        result.back().channel = name;
        result.back().part = static_cast<std::int32_t>(result.size() - first - 1);
        result.back().n = 0;
      }
      tile_index_t& index = result.back();
      ++index.n;
      index.submap_id.push_back(key.submap_id);
      index.x.push_back(key.x);
      index.y.push_back(key.y);
      index.z.push_back(key.z);
      index.revision.push_back(tile.revision);
    }
    for (std::size_t i = first; i < result.size(); ++i)
      result[i].n_parts = static_cast<std::int32_t>(result.size() - first);
  }
  return result;
}

std::map<std::string, std::int64_t> Outbox::counts() const {
  std::map<std::string, std::int64_t> result;
  for (const auto& [name, channel] : channels_) result[name] = channel.count;
  return result;
}

std::int64_t Outbox::bytes(const std::string& channel) const {
  const auto it = channels_.find(channel);
  return it == channels_.end() ? 0 : it->second.bytes;
}

}  // namespace fusion_slam
