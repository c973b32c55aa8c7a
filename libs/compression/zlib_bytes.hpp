// Bytes in zlib's format (RFC 1950), by libdeflate: the same format at a third of zlib's time,
// because whole buffers, which is all that messages are, need no streaming state. Thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace fusion_slam {

// Fastest level; equal input gives equal bytes. Throws std::runtime_error without memory.
std::vector<std::uint8_t> zlib_compress(const std::uint8_t* raw, std::size_t size_bytes);

// The inverse; nothing when the data is damaged, cut short, or would be larger than max_size_bytes.
// Takes memory in proportion to what `data` can hold, however large max_size_bytes is.
std::optional<std::vector<std::uint8_t>> zlib_decompress(const std::uint8_t* data,
                                                         std::size_t size_bytes,
                                                         std::size_t max_size_bytes);

// Into `raw`, which has room for exactly what comes out. False: damaged, or of another size; `raw`
// is then unspecified.
bool zlib_decompress_into(const std::uint8_t* data, std::size_t size_bytes, std::uint8_t* raw,
                          std::size_t raw_size_bytes);

// CRC-32 as in RFC 1952.
std::uint32_t crc32_of(const std::uint8_t* data, std::size_t size_bytes);

}  // namespace fusion_slam
