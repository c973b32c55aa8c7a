#include "libs/camera/image_codec.hpp"

#include <stdexcept>

#include <opencv2/imgcodecs.hpp>

#include "libs/compression/zlib_bytes.hpp"

namespace fusion_slam {
namespace {

bool side_ok(int px) { return px > 0 && px <= kMaxImageSide; }

bool size_ok(int width_px, int height_px, std::string* why) {
  if (side_ok(width_px) && side_ok(height_px)) return true;
  *why = "image size " + std::to_string(width_px) + " x " + std::to_string(height_px) +
         " is not between 1 and " + std::to_string(kMaxImageSide);
  return false;
}

}  // namespace

Bytes encode_jpeg(const cv::Mat& bgr, int quality, bool own_tables) {
  Bytes bytes;
  if (!cv::imencode(
          ".jpg", bgr, bytes,
          {cv::IMWRITE_JPEG_QUALITY, quality, cv::IMWRITE_JPEG_OPTIMIZE, own_tables ? 1 : 0}))
    throw std::invalid_argument("encode_jpeg: OpenCV cannot encode this image");
  return bytes;
}

std::optional<cv::Size> jpeg_size(const Bytes& bytes) {
  if (bytes.size() < 4 || bytes[0] != 0xFF || bytes[1] != 0xD8) return std::nullopt;
  std::size_t at = 2;
  while (at + 9 < bytes.size()) {
    if (bytes[at] != 0xFF) return std::nullopt;
    const int marker = bytes[at + 1];
    const auto be16 = [&](std::size_t i) { return 256 * bytes[i] + bytes[i + 1]; };
    // Start-of-frame markers are C0..CF without C4 (Huffman tables), C8 (reserved) and CC
    // (arithmetic conditioning).
    if (marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC)
      return cv::Size(be16(at + 7), be16(at + 5));
    if (marker == 0xFF) {
      ++at;  // fill byte
    } else if (marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8)) {
      at += 2;  // markers without a segment
    } else {
      at += 2 + static_cast<std::size_t>(be16(at + 2));
    }
  }
  return std::nullopt;
}

std::optional<cv::Mat> decode_jpeg(const Bytes& bytes, int width_px, int height_px,
                                   std::string* why) {
  if (!size_ok(width_px, height_px, why)) return std::nullopt;
  const auto size = jpeg_size(bytes);
  if (!size) return *why = "colour is not a JPEG image", std::nullopt;
  if (size->width != width_px || size->height != height_px)
    return *why = "the JPEG image is " + std::to_string(size->width) + " x " +
                  std::to_string(size->height) + ", the message says " + std::to_string(width_px) +
                  " x " + std::to_string(height_px),
           std::nullopt;
  cv::Mat bgr;
  try {
    bgr = cv::imdecode(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    bgr.release();
  }
  if (bgr.empty() || bgr.cols != width_px || bgr.rows != height_px)
    return *why = "the JPEG image cannot be decoded", std::nullopt;
  return bgr;
}

Bytes depth_bytes(const cv::Mat& depth_mm) {
  if (depth_mm.type() != CV_16UC1) throw std::invalid_argument("depth_bytes: not CV_16UC1");
  Bytes bytes;
  bytes.reserve(depth_mm.total() * 2);
  for (int v = 0; v < depth_mm.rows; ++v) {
    const auto* row = depth_mm.ptr<std::uint16_t>(v);
    for (int u = 0; u < depth_mm.cols; ++u) {
      bytes.push_back(static_cast<std::uint8_t>(row[u] & 0xFF));
      bytes.push_back(static_cast<std::uint8_t>(row[u] >> 8));
    }
  }
  return bytes;
}

Bytes encode_depth(const cv::Mat& depth_mm) {
  const Bytes raw = depth_bytes(depth_mm);
  return zlib_compress(raw.data(), raw.size());
}

std::optional<cv::Mat> depth_from_bytes(const Bytes& bytes, int width_px, int height_px,
                                        std::string* why) {
  if (!size_ok(width_px, height_px, why)) return std::nullopt;
  const std::size_t expected =
      std::size_t{2} * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  if (bytes.size() != expected)
    return *why = "depth has " + std::to_string(bytes.size()) + " bytes instead of " +
                  std::to_string(expected),
           std::nullopt;
  cv::Mat depth(height_px, width_px, CV_16UC1);
  std::size_t at = 0;
  for (int v = 0; v < height_px; ++v) {
    auto* row = depth.ptr<std::uint16_t>(v);
    for (int u = 0; u < width_px; ++u, at += 2)
      row[u] = static_cast<std::uint16_t>(bytes[at] | (bytes[at + 1] << 8));
  }
  return depth;
}

std::optional<cv::Mat> decode_depth(const Bytes& bytes, int width_px, int height_px,
                                    std::string* why) {
  if (!size_ok(width_px, height_px, why)) return std::nullopt;
  // zlib shrinks by a factor of 1032 at most: what is smaller cannot hold the image.
  const std::size_t expected =
      std::size_t{2} * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  if (bytes.size() < expected / 1100)
    return *why = "zipped depth is too short for its size", std::nullopt;
  // Little-endian on the wire, as in this machine's memory.
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
  cv::Mat depth(height_px, width_px, CV_16UC1);
  if (!zlib_decompress_into(bytes.data(), bytes.size(), depth.data, expected))
    return *why = "zipped depth is damaged or of another size", std::nullopt;
  return depth;
}

}  // namespace fusion_slam
