#include "libs/features/lsh_index.hpp"

#include <algorithm>
#include <numeric>
#include <random>

namespace fusion_slam {

LshIndex::LshIndex(int tables, int key_bits, std::uint32_t seed) {
  std::mt19937 random(seed);
  for (int t = 0; t < tables; ++t) {
    // Fisher-Yates by hand: std::shuffle may differ between standard libraries.
    std::vector<int> bits(256);
    std::iota(bits.begin(), bits.end(), 0);
    for (int i = 0; i < key_bits; ++i)
      std::swap(bits[i],
                bits[i + static_cast<int>(random() % static_cast<std::uint32_t>(256 - i))]);
    bits.resize(key_bits);
    tables_.push_back({bits, {}});
  }
}

std::uint32_t LshIndex::key(const Table& table, const Descriptor& descriptor) {
  std::uint32_t key = 0;
  for (const int bit : table.bits)
    key = key << 1U | static_cast<std::uint32_t>(descriptor[bit / 64] >> (bit % 64) & 1U);
  return key;
}

void LshIndex::add(const Descriptor& descriptor, int label) {
  const auto number = static_cast<std::uint32_t>(entries_.size());
  entries_.push_back({descriptor, label});
  for (Table& table : tables_) table.buckets[key(table, descriptor)].push_back(number);
}

std::vector<LshIndex::Near> LshIndex::near(const Descriptor& query, int max_distance) const {
  std::vector<std::uint32_t> found;
  for (const Table& table : tables_) {
    const auto bucket = table.buckets.find(key(table, query));
    if (bucket == table.buckets.end()) continue;
    for (const std::uint32_t number : bucket->second)
      if (hamming(entries_[number].descriptor, query) <= max_distance) found.push_back(number);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<Near> result;
  result.reserve(found.size());
  for (const std::uint32_t number : found)
    result.push_back({entries_[number].label, hamming(entries_[number].descriptor, query)});
  return result;
}

}  // namespace fusion_slam
