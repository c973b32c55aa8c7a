#include "libs/submaps/changed_tiles.hpp"

namespace fusion_slam {
namespace {

// FNV-1a, 64 bits.
std::uint64_t fingerprint(const Tile& tile) {
  std::uint64_t hash = 14695981039346656037ULL;
  const auto mix = [&hash](std::uint8_t byte) { hash = (hash ^ byte) * 1099511628211ULL; };
  mix(static_cast<std::uint8_t>(tile.encoding));
  for (const std::uint8_t byte : tile.data) mix(byte);
  return hash;
}

}  // namespace

std::optional<Tile> ChangedTiles::offer(Tile tile) {
  const bool empty = tile.encoding == TileEncoding::kEmpty;
  const auto it = published_.find(tile.key);
  if (it == published_.end() && empty) return std::nullopt;
  const std::uint64_t hash = fingerprint(tile);
  if (it != published_.end() && it->second.fingerprint == hash) return std::nullopt;
  Published& published = published_[tile.key];
  published.fingerprint = hash;
  published.empty = empty;
  tile.revision = ++published.revision;
  return tile;
}

std::set<TileKey> ChangedTiles::present() const {
  std::set<TileKey> keys;
  for (const auto& [key, published] : published_)
    if (!published.empty) keys.insert(key);
  return keys;
}

}  // namespace fusion_slam
