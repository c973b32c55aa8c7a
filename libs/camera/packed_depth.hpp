// Depth images, packed without loss for networks: about half of what zlib makes of them.
// Structured-light cameras know some hundred depths only (steps of disparity), so pixels are ranks
// among the image's own values; what remains after a guess from their neighbours
// (libs/camera/depth_guess) is coded by asymmetric numeral systems with a table for each kind of
// neighbourhood. Bytes: docs/formats.md. Pure; any thread.
#pragma once

#include <optional>
#include <string>

#include "libs/camera/image_codec.hpp"

namespace fusion_slam {

// CV_16UC1, mm, 0: none; at most kMaxImageSide a side. Equal images give equal bytes. Throws
// std::invalid_argument when it is no such image.
Bytes encode_packed_depth(const cv::Mat& depth_mm);

// The inverse, of exactly this size; nothing, with a reason in `why`, when the bytes are damaged.
std::optional<cv::Mat> decode_packed_depth(const Bytes& bytes, int width_px, int height_px,
                                           std::string* why);

}  // namespace fusion_slam
