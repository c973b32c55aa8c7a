// A set of ORB features of one image (Rublee et al. 2011: oriented FAST, rotated BRIEF).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace fusion_slam {

using Descriptor = std::array<std::uint64_t, 4>;  // 256 bits
constexpr std::size_t kDescriptorBytes = 32;

struct Feature {
  float u_px = 0.0F;  // in the full-size image; pixel centres are at integers
  float v_px = 0.0F;
  float depth_m = 0.0F;  // along the optical axis; 0: unknown
  float angle_rad = 0.0F;
  std::int8_t octave = 0;
  float depth_sigma_m = 0.0F;  // standard deviation of depth_m; 0: unknown
};

// features[i] and descriptors[i] belong together.
struct FeatureSet {
  std::vector<Feature> features;
  std::vector<Descriptor> descriptors;

  std::size_t size() const { return features.size(); }
  bool empty() const { return features.empty(); }
};

// Number of bits that differ, 0 .. 256.
inline int hamming(const Descriptor& a, const Descriptor& b) {
  return __builtin_popcountll(a[0] ^ b[0]) + __builtin_popcountll(a[1] ^ b[1]) +
         __builtin_popcountll(a[2] ^ b[2]) + __builtin_popcountll(a[3] ^ b[3]);
}

inline Descriptor descriptor_from_bytes(const std::uint8_t* bytes) {
  Descriptor d;
  std::memcpy(d.data(), bytes, kDescriptorBytes);
  return d;
}

inline void descriptor_to_bytes(const Descriptor& d, std::uint8_t* bytes) {
  std::memcpy(bytes, d.data(), kDescriptorBytes);
}

}  // namespace fusion_slam
