#include "libs/compression/rans.hpp"

#include <algorithm>
#include <numeric>

namespace fusion_slam {

std::vector<std::uint16_t> rans_frequencies(const std::vector<std::uint32_t>& counts) {
  std::vector<std::uint16_t> frequencies(counts.size(), 0);
  const std::uint64_t total = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  if (total == 0) return frequencies;
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    const std::uint64_t share = (counts[i] * std::uint64_t{kRansOne} + total / 2) / total;
    frequencies[i] = static_cast<std::uint16_t>(std::max<std::uint64_t>(1, share));
    sum += frequencies[i];
  }
  // What rounding has left over or taken too much: the most frequent symbol feels it least.
  while (sum != kRansOne) {
    const auto most = std::max_element(frequencies.begin(), frequencies.end());
    const std::uint32_t change =
        sum < kRansOne ? kRansOne - sum : std::min<std::uint32_t>(sum - kRansOne, *most / 2U);
    *most = static_cast<std::uint16_t>(sum < kRansOne ? *most + change : *most - change);
    sum = sum < kRansOne ? sum + change : sum - change;
  }
  return frequencies;
}

void RansEncoder::finish(std::vector<std::uint8_t>* out) {
  words_.push_back(static_cast<std::uint16_t>(x_));
  words_.push_back(static_cast<std::uint16_t>(x_ >> 16));
  std::swap(words_[words_.size() - 1], words_[words_.size() - 2]);  // low half first when reversed
  out->reserve(out->size() + 2 * words_.size());
  for (auto word = words_.rbegin(); word != words_.rend(); ++word) {
    out->push_back(static_cast<std::uint8_t>(*word));
    out->push_back(static_cast<std::uint8_t>(*word >> 8));
  }
  words_.clear();
  x_ = kRansLeast;
}

RansDecoder::RansDecoder(const std::uint8_t* data, std::size_t size_bytes)
    : at_(data), end_(data + size_bytes) {
  if (size_bytes < 4) {
    short_ = true;
    return;
  }
  for (int i = 3; i >= 0; --i) x_ = i == 3 ? at_[i] : x_ << 8 | at_[i];
  at_ += 4;
}

}  // namespace fusion_slam
