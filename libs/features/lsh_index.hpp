// Nearest binary descriptors by hashing: each table's key is a few of the 256 bits, so that
// descriptors that differ little share a bucket in some table (Indyk & Motwani 1998: bit sampling
// for the Hamming distance). Grows one descriptor at a time and never rebuilds. Written here
// because FLANN 1.9.2's index of the same kind draws its bits from std::random_device: two runs of
// one program give different neighbours.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "libs/features/feature.hpp"

namespace fusion_slam {

class LshIndex {
 public:
  LshIndex(int tables, int key_bits, std::uint32_t seed);

  // `label` is handed back by for_near; labels may repeat.
  void add(const Descriptor& descriptor, int label);
  std::size_t size() const { return entries_.size(); }

  struct Near {
    int label = 0;
    int distance = 0;
  };
  // Entries within max_distance that share a bucket with the query in at least one table, each
  // once, in the order they were added. Misses some; never wrong about the distance.
  std::vector<Near> near(const Descriptor& query, int max_distance) const;

 private:
  struct Entry {
    Descriptor descriptor;
    int label = 0;
  };
  struct Table {
    std::vector<int> bits;
    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>>
        buckets;  // looked up, never iterated
  };
  static std::uint32_t key(const Table& table, const Descriptor& descriptor);

  std::vector<Table> tables_;
  std::vector<Entry> entries_;
};

}  // namespace fusion_slam
