// CAMERA between the wire (bot_core.images_t) and RgbdFrame. Pure; any thread.
#pragma once

#include <optional>
#include <string>

#include "bot_core/images_t.hpp"
#include "libs/camera/image_codec.hpp"
#include "libs/camera/rgbd_frame.hpp"

namespace fusion_slam {

// How images go over the wire. Plain: zlib's depth is bot_core's own DEPTH_MM_ZIPPED, which every
// program of a lab reads. Packed: depth as in libs/camera/packed_depth, which only ours reads, JPEG
// with Huffman tables of its own; half of the network for 3 ms more of a processor a frame on
// either side.
enum class ImageCoding { kPlain, kPacked };
// As configurations and options name them, which have checked the name: packed, or else plain.
inline ImageCoding image_coding(const std::string& name) {
  return name == "packed" ? ImageCoding::kPacked : ImageCoding::kPlain;
}

// Packed depth's image_type, which bot_core leaves free: programs that don't know it find no depth.
inline constexpr std::int16_t kDepthPacked = 1001;

// LEFT (MJPEG) and depth. The JPEG's quality starts at `quality` and falls until both images fit
// kMaxFrameBytes. Throws std::invalid_argument when the two images have not one size or not their
// types.
bot_core::images_t to_message(const RgbdFrame& frame, int quality = kJpegQuality,
                              ImageCoding coding = ImageCoding::kPlain);
// The same with colour that is a JPEG already, sent as it is.
bot_core::images_t to_message(std::int64_t utime_us, const Bytes& colour_jpeg,
                              const cv::Mat& depth_mm, ImageCoding coding = ImageCoding::kPlain);

// The message's depth, however it is coded; nullptr: there is none.
const bot_core::image_t* depth_image(const bot_core::images_t& message);
// CV_16UC1, mm. Nothing, with a reason in `why`: there is none, or its bytes do not decode.
std::optional<cv::Mat> decode_depth(const bot_core::images_t& message, std::string* why);

// Colour from LEFT (MJPEG, RGB or GRAY), depth from DEPTH_MM_ZIPPED, packed or DEPTH_MM; depth
// without a usable image is all 0 (none). Nothing, with a reason in `why`, when there is no colour,
// sizes contradict each other or bytes do not decode.
std::optional<RgbdFrame> from_message(const bot_core::images_t& message, std::string* why);

}  // namespace fusion_slam
