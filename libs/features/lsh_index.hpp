// Nearest binary descriptors by hashing: each table's key is a few of the 256 bits, so that
// descriptors that differ little share a bucket in some table (Indyk & Motwani 1998: bit sampling
// for the Hamming distance). Grows and shrinks one descriptor at a time and never rebuilds. Written
// here because FLANN 1.9.2's index of the same kind draws its bits from std::random_device: two
// runs of one program give different neighbours.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <vector>

#include "libs/features/feature.hpp"

namespace fusion_slam {

class LshIndex {
 public:
  LshIndex(int tables, int key_bits, std::uint32_t seed);

  // `label` is handed back by near(); labels may repeat.
  void add(const Descriptor& descriptor, int label);
  // All descriptors of the label are gone; their room is given back when they are a quarter of all.
  // Labels that are removed may not come again.
  void remove(int label);
  // All but the labels that are wanted are gone, and their room is given back at once.
  void keep_only(const std::function<bool(int label)>& wanted);
  std::size_t size() const { return entries_.size() - n_removed_; }

  struct Near {
    int label = 0;
    int distance = 0;
  };
  // Entries within max_distance that share a bucket with the query in at least one table, each
  // once, in the order they were added. Misses some; never wrong about the distance.
  std::vector<Near> near(const Descriptor& query, int max_distance) const;

 private:
  static constexpr std::uint32_t kNone = 0xffffffffU;
  struct Entry {
    Descriptor descriptor;
    int label = 0;
  };
  struct Table {
    std::vector<int> bits;
    std::vector<std::uint32_t> first;  // by key: the entry of that bucket that came last
  };
  static std::uint32_t key(const Table& table, const Descriptor& descriptor);

  void link(std::uint32_t number);
  void clean_up();

  std::vector<Table> tables_;
  std::vector<Entry> entries_;
  std::vector<std::uint32_t> next_;  // in the bucket, by entry and table
  std::map<int, std::size_t> n_of_label_;
  std::set<int> removed_;  // labels whose entries are still here, n_removed_ of them
  std::size_t n_removed_ = 0;
};

}  // namespace fusion_slam
