// Which freshly encoded tiles really differ from what was published, and their revisions.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "libs/tiles/tile.hpp"

namespace fusion_slam {

class ChangedTiles {
 public:
  // The tile with its revision set, or nothing when its content is what was offered last (or empty
  // and never published).
  std::optional<Tile> offer(Tile tile);

  // Keys that were published and are not empty now.
  std::set<TileKey> present() const;

 private:
  struct Published {
    std::uint64_t fingerprint = 0;
    std::int64_t revision = 0;
    bool empty = true;
  };
  std::map<TileKey, Published> published_;
};

}  // namespace fusion_slam
