// Tiles as a bad network or disk leaves them.
#pragma once

#include <cstdint>
#include <random>

#include <gtest/gtest.h>

#include "libs/tiles/tile.hpp"

namespace fusion_slam {

// Cut and changed at random, 2,000 times from seed 1: decode(tile) must survive all of it, and what
// was cut gives nothing. Decode returns std::optional.
template <class Decode>
void expect_damage_is_noticed(const Tile& tile, Decode decode) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    Tile damaged = tile;
    damaged.data.resize(random() % (tile.data.size() + 1));
    for (int i = 0; i < 3 && !damaged.data.empty(); ++i)
      damaged.data[random() % damaged.data.size()] = static_cast<std::uint8_t>(random());
    const auto decoded = decode(damaged);
    if (damaged.data.size() < tile.data.size()) {
      EXPECT_FALSE(decoded);
    }
  }
}

}  // namespace fusion_slam
