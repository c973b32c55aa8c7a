// Big-endian numbers in byte buffers, as LCM writes them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fusion_slam {

inline std::uint64_t read_big_endian(const std::uint8_t* bytes, std::size_t n_bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < n_bytes; ++i) value = (value << 8) | bytes[i];
  return value;
}

// Two's complement of 1, 2, 4 or 8 bytes.
inline std::int64_t read_signed_big_endian(const std::uint8_t* bytes, std::size_t n_bytes) {
  const std::uint64_t value = read_big_endian(bytes, n_bytes);
  const unsigned unused_bits = static_cast<unsigned>(64 - 8 * n_bytes);
  return static_cast<std::int64_t>(value << unused_bits) >> unused_bits;
}

inline void write_big_endian(std::uint64_t value, std::size_t n_bytes, std::uint8_t* out) {
  for (std::size_t i = n_bytes; i-- > 0; value >>= 8) out[i] = static_cast<std::uint8_t>(value);
}

}  // namespace fusion_slam
