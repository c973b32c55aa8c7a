#include "libs/bus/tile_channel.hpp"

#include <utility>

#include "fusion_slam/resend_t.hpp"
#include "libs/messages/convert.hpp"

namespace fusion_slam {
namespace {

// Requests per message of 28 bytes each, below 60 KB.
constexpr std::size_t kMostTiles = 1500;

}  // namespace

struct TileReceiver::Shared {
  std::mutex mutex;
  std::map<TileKey, std::int64_t> have;    // newest revision of each tile received
  std::map<TileKey, std::int64_t> behind;  // seen newer in the last index

  // What to ask for: tiles never received at once, newer revisions when they have not come by
  // themselves since the last index.
  resend_t wanted(const tile_index_t& index) {
    const std::lock_guard<std::mutex> lock(mutex);
    resend_t request{};
    request.channel = index.channel;
    for (std::size_t i = 0; i < index.revision.size() && request.x.size() < kMostTiles; ++i) {
      const TileKey key{index.submap_id[i], index.x[i], index.y[i], index.z[i]};
      const auto mine = have.find(key);
      if (mine != have.end() && mine->second >= index.revision[i]) {
        behind.erase(key);
        continue;
      }
      const auto before = behind.find(key);
      const bool ask =
          mine == have.end() || (before != behind.end() && mine->second < before->second);
      behind[key] = index.revision[i];
      if (!ask) continue;
      request.submap_id.push_back(key.submap_id);
      request.x.push_back(key.x);
      request.y.push_back(key.y);
      request.z.push_back(key.z);
    }
    request.n_tiles = static_cast<std::int32_t>(request.x.size());
    return request;
  }
};

void TilePublisher::publish(const Tile& tile) { bus_.publish_tile(channel_, to_message(tile)); }

TileReceiver::TileReceiver(Bus& bus, const std::string& channel,
                           std::function<void(const Tile&)> on_tile)
    : shared_(std::make_shared<Shared>()), on_tile_(std::move(on_tile)) {
  bus.subscribe<tile_t>(channel, Policy::kKeepAll,
                        [this](const tile_t& message) { receive(message); });
  if (bus.mode() != Mode::kLive) return;  // a replay loses nothing: the bus itself asks for gaps
  bus.listen<tile_index_t>(channel + "_INDEX", [shared = shared_, &bus](const tile_index_t& index) {
    resend_t request = shared->wanted(index);
    if (request.n_tiles > 0) bus.publish("RESEND", std::move(request));
  });
}

void TileReceiver::receive(const tile_t& message) {
  const Tile tile = from_message(message);
  {
    const std::lock_guard<std::mutex> lock(shared_->mutex);
    const auto [mine, first] = shared_->have.try_emplace(tile.key, tile.revision);
    if (!first) {
      if (mine->second >= tile.revision) return;
      mine->second = tile.revision;
    }
  }
  on_tile_(tile);
}

}  // namespace fusion_slam
