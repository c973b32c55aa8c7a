// CAMERA between the wire (bot_core.images_t) and RgbdFrame. Pure; any thread.
#pragma once

#include <optional>
#include <string>

#include "bot_core/images_t.hpp"
#include "libs/camera/image_codec.hpp"
#include "libs/camera/rgbd_frame.hpp"

namespace fusion_slam {

// LEFT (MJPEG) and DEPTH_MM_ZIPPED. The JPEG's quality starts at `quality` and falls until both
// images fit kMaxFrameBytes. Throws std::invalid_argument when the two images have not one size or
// not their types.
bot_core::images_t to_message(const RgbdFrame& frame, int quality = kJpegQuality);
// The same with colour that is a JPEG already, sent as it is.
bot_core::images_t to_message(std::int64_t utime_us, const Bytes& colour_jpeg,
                              const cv::Mat& depth_mm);

// Colour from LEFT (MJPEG, RGB or GRAY), depth from DEPTH_MM_ZIPPED or DEPTH_MM; depth without a
// usable image is all 0 (none). Nothing, with a reason in `why`, when there is no colour, sizes
// contradict each other or bytes do not decode.
std::optional<RgbdFrame> from_message(const bot_core::images_t& message, std::string* why);

}  // namespace fusion_slam
