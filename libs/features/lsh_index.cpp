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
  entries_.push_back({descriptor, label});
  ++n_of_label_[label];
  link(static_cast<std::uint32_t>(entries_.size() - 1));
}

void LshIndex::link(std::uint32_t number) {
  for (Table& table : tables_)
    next_.push_back(std::exchange(table.first[key(table, entries_[number].descriptor)], number));
}

void LshIndex::remove(int label) {
  const auto known = n_of_label_.find(label);
  if (known == n_of_label_.end()) return;
  n_removed_ += known->second;
  n_of_label_.erase(known);
  removed_.insert(label);
  if (4 * n_removed_ > entries_.size()) clean_up();
}

void LshIndex::keep_only(const std::function<bool(int label)>& wanted) {
  for (auto it = n_of_label_.begin(); it != n_of_label_.end();) {
    if (!wanted(it->first)) {
      removed_.insert(removed_.end(), it->first);
      n_removed_ += it->second;
      it = n_of_label_.erase(it);
    } else {
      ++it;
    }
  }
  if (n_removed_ == 0) return;
  clean_up();
  entries_.shrink_to_fit();
  next_.shrink_to_fit();
}

void LshIndex::clean_up() {
  entries_.erase(std::remove_if(entries_.begin(), entries_.end(),
                                [this](const Entry& e) { return removed_.count(e.label) > 0; }),
                 entries_.end());
  removed_.clear();
  n_removed_ = 0;
  next_.clear();
  for (Table& table : tables_) std::fill(table.first.begin(), table.first.end(), kNone);
  for (std::uint32_t number = 0; number < entries_.size(); ++number) link(number);
}

std::vector<LshIndex::Near> LshIndex::near(const Descriptor& query, int max_distance) const {
  std::vector<std::uint32_t> found;
  for (std::size_t t = 0; t < tables_.size(); ++t)
    for (std::uint32_t number = tables_[t].first[key(tables_[t], query)]; number != kNone;
         number = next_[number * tables_.size() + t])
      if (hamming(entries_[number].descriptor, query) <= max_distance &&
          (removed_.empty() || removed_.count(entries_[number].label) == 0))
        found.push_back(number);
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<Near> result;
  result.reserve(found.size());
  for (const std::uint32_t number : found)
    result.push_back({entries_[number].label, hamming(entries_[number].descriptor, query)});
  return result;
}

}  // namespace fusion_slam
