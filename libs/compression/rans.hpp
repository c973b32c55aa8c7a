// Entropy coding by asymmetric numeral systems: Duda 2013, "Asymmetric numeral systems: entropy
// coding combining speed of Huffman coding with compression rate of arithmetic coding", the range
// variant (section 3.3): a symbol of probability f / 2^11 takes a state x to
// 2^11 (x div f) + start + x mod f, and back. The state stays in [2^16, 2^32) by words of 16 bits.
// Symbols come out in the order opposite to that in which they went in. Pure; any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fusion_slam {

inline constexpr int kRansBits = 11;
inline constexpr std::uint32_t kRansOne = 1U << kRansBits;  // the sum of a table's frequencies
inline constexpr std::uint32_t kRansLeast = 1U << 16;       // of a state

// Counts as frequencies that add up to kRansOne; each symbol that occurs keeps at least 1. All 0
// when nothing occurs. At most kRansOne counts.
std::vector<std::uint16_t> rans_frequencies(const std::vector<std::uint32_t>& counts);

class RansEncoder {
 public:
  // A symbol that has [start, start + frequency) of [0, kRansOne); frequency > 0.
  void put(std::uint32_t start, std::uint32_t frequency) {
    if (x_ >= std::uint64_t{frequency} << (32 - kRansBits)) {
      words_.push_back(static_cast<std::uint16_t>(x_));
      x_ >>= 16;
    }
    const auto x = static_cast<std::uint32_t>(x_);
    x_ = (std::uint64_t{x / frequency} << kRansBits) + start + x % frequency;
  }
  // A number below 2^bits; bits <= kRansBits.
  void put_bits(std::uint32_t value, int bits) {
    put(value << (kRansBits - bits), kRansOne >> bits);
  }
  // Everything, appended to `out`: the state (4 bytes), then the words, all little-endian.
  void finish(std::vector<std::uint8_t>* out);

 private:
  std::uint64_t x_ = kRansLeast;
  std::vector<std::uint16_t> words_;
};

class RansDecoder {
 public:
  // The bytes must outlive this. Fewer than 4: good() is false from the start.
  RansDecoder(const std::uint8_t* data, std::size_t size_bytes);

  // Which of [0, kRansOne) comes next; its symbol's place is then given to take().
  std::uint32_t peek() const { return x_ & (kRansOne - 1); }
  // `within`: peek() - start.
  void take(std::uint32_t within, std::uint32_t frequency) {
    x_ = frequency * (x_ >> kRansBits) + within;
    if (x_ < kRansLeast) refill();
  }
  std::uint32_t take_bits(int bits) {
    const std::uint32_t value = peek() >> (kRansBits - bits);
    take(peek() & ((kRansOne >> bits) - 1), kRansOne >> bits);
    return value;
  }
  // After the last symbol: all bytes were used and the state is what the encoder began with.
  bool at_end() const { return !short_ && at_ == end_ && x_ == kRansLeast; }

 private:
  void refill() {
    if (end_ - at_ < 2) {
      short_ = true;
      x_ = kRansLeast;
      return;
    }
    x_ = x_ << 16 | static_cast<std::uint32_t>(at_[0] | at_[1] << 8);
    at_ += 2;
  }

  const std::uint8_t* at_;
  const std::uint8_t* end_;
  std::uint32_t x_ = kRansLeast;
  bool short_ = false;
};

}  // namespace fusion_slam
