// Random numbers that are the same on every machine: the standard fixes mt19937_64 but not its
// distributions, so those are ours. One thread at a time.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

namespace fusion_slam {

// Mixes bits so that neighbouring seeds have nothing in common (Steele et al. 2014, SplitMix64).
inline std::uint64_t mix_bits(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

class Random {
 public:
  // Independent streams of one seed: `stream` says what for, `index` which frame or scan.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0, std::uint64_t index = 0)
      : engine_(mix_bits(mix_bits(mix_bits(seed) ^ stream) ^ index)) {}

  std::uint64_t bits() { return engine_(); }
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }  // [0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  // Box & Muller 1958.
  double gaussian() {
    if (has_spare_) return has_spare_ = false, spare_;
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    const double angle = 2.0 * M_PI * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

 private:
  std::mt19937_64 engine_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace fusion_slam
