#include "libs/features/lsh_index.hpp"

#include <algorithm>
#include <numeric>
#include <random>
#include <utility>

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
    tables_.push_back({bits, std::vector<std::uint32_t>(std::size_t{1} << key_bits, kNone)});
  }
}

std::uint32_t LshIndex::key(const Table& table, const Descriptor& descriptor) {
  std::uint32_t key = 0;
  for (const int bit : table.bits)
    key = key << 1U | static_cast<std::uint32_t>(descriptor[bit / 64] >> (bit % 64) & 1U);
  return key;
}

void LshIndex::add(const Descriptor& descriptor, int label) {
  auto number = static_cast<std::uint32_t>(entries_.size());
  if (free_.empty()) {
    entries_.emplace_back();
    next_.resize(next_.size() + tables_.size(), kNone);
  } else {
    number = free_.back();
    free_.pop_back();
    reused_ = true;
  }
  const auto [of_label, is_first] = of_label_.emplace(label, number);
  entries_[number] = {descriptor, label, is_first ? kNone : of_label->second};
  of_label->second = number;
  for (std::size_t t = 0; t < tables_.size(); ++t)
    next(number, t) = std::exchange(tables_[t].first[key(tables_[t], descriptor)], number);
}

void LshIndex::remove(int label) {
  const auto of_label = of_label_.find(label);
  if (of_label == of_label_.end()) return;
  for (std::uint32_t number = of_label->second; number != kNone;
       number = entries_[number].next_of_label) {
    for (std::size_t t = 0; t < tables_.size(); ++t) {
      std::uint32_t* link = &tables_[t].first[key(tables_[t], entries_[number].descriptor)];
      while (*link != number) link = &next(*link, t);
      *link = next(number, t);
    }
    free_.push_back(number);
  }
  of_label_.erase(of_label);
}

std::vector<LshIndex::Near> LshIndex::near(const Descriptor& query, int max_distance) const {
  std::vector<std::uint32_t> found;
  for (std::size_t t = 0; t < tables_.size(); ++t)
    for (std::uint32_t number = tables_[t].first[key(tables_[t], query)]; number != kNone;
         number = next_[number * tables_.size() + t])
      if (hamming(entries_[number].descriptor, query) <= max_distance) found.push_back(number);
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  if (reused_)
    std::stable_sort(found.begin(), found.end(), [this](std::uint32_t a, std::uint32_t b) {
      return entries_[a].label < entries_[b].label;
    });
  std::vector<Near> result;
  result.reserve(found.size());
  for (const std::uint32_t number : found)
    result.push_back({entries_[number].label, hamming(entries_[number].descriptor, query)});
  return result;
}

}  // namespace fusion_slam
