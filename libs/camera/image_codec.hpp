// Colour and depth images as bytes: JPEG, and zlib of little-endian uint16 mm. Every decoder checks
// sizes before it believes them; none of these throws on bad bytes. Pure; any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace fusion_slam {

using Bytes = std::vector<std::uint8_t>;

// 90: no visible loss, and ORB features move by less than their own noise; 640x480 takes 60-110 KB.
inline constexpr int kJpegQuality = 90;
// Images of a message together (DESIGN.md, principle 5).
inline constexpr std::size_t kMaxFrameBytes = 400'000;
inline constexpr int kMaxImageSide = 8192;

// own_tables: 2 to 7 % fewer bytes for the same pixels, in more than twice the time.
Bytes encode_jpeg(const cv::Mat& bgr, int quality = kJpegQuality, bool own_tables = false);
// CV_8UC3 of exactly this size, or nothing with a reason.
std::optional<cv::Mat> decode_jpeg(const Bytes& bytes, int width_px, int height_px,
                                   std::string* why);
// Width and height from the JPEG's own header, without decoding.
std::optional<cv::Size> jpeg_size(const Bytes& bytes);

Bytes encode_depth(const cv::Mat& depth_mm);  // zlib
Bytes depth_bytes(const cv::Mat& depth_mm);   // uncompressed, little-endian, rows without gaps
std::optional<cv::Mat> decode_depth(const Bytes& bytes, int width_px, int height_px,
                                    std::string* why);
std::optional<cv::Mat> depth_from_bytes(const Bytes& bytes, int width_px, int height_px,
                                        std::string* why);

}  // namespace fusion_slam
