#include "libs/tiles/tile.hpp"

#include <algorithm>
#include <stdexcept>

#include <zlib.h>

namespace fusion_slam {

std::vector<std::uint8_t> deflate_bytes(const std::vector<std::uint8_t>& raw) {
  if (raw.empty()) return {};
  uLongf size = compressBound(raw.size());
  std::vector<std::uint8_t> out(size);
  if (compress2(out.data(), &size, raw.data(), raw.size(), 1) != Z_OK)
    throw std::runtime_error("zlib could not compress " + std::to_string(raw.size()) + " bytes");
  out.resize(size);
  return out;
}

std::optional<std::vector<std::uint8_t>> inflate_bytes(const std::uint8_t* data, std::size_t size,
                                                       std::size_t max_size_bytes) {
  std::vector<std::uint8_t> out;
  if (size == 0) return out;
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) return std::nullopt;
  stream.next_in = const_cast<Bytef*>(data);
  stream.avail_in = static_cast<uInt>(size);
  int code = Z_OK;
  while (code == Z_OK && out.size() < max_size_bytes + 1) {
    const std::size_t done = out.size();
    // Grows with what really comes out, so that a short damaged stream can't claim much memory.
    out.resize(std::min(std::max<std::size_t>(2 * done, 4096), max_size_bytes + 1));
    stream.next_out = out.data() + done;
    stream.avail_out = static_cast<uInt>(out.size() - done);
    code = inflate(&stream, Z_NO_FLUSH);
    out.resize(out.size() - stream.avail_out);
    if (code == Z_BUF_ERROR) break;
  }
  inflateEnd(&stream);
  if (code != Z_STREAM_END || out.size() > max_size_bytes) return std::nullopt;
  return out;
}

}  // namespace fusion_slam
