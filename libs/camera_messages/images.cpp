#include "libs/camera_messages/images.hpp"

#include <algorithm>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

#include "libs/camera/packed_depth.hpp"

namespace fusion_slam {
namespace {

using bot_core::image_t;
using bot_core::images_t;

constexpr int kWorstQuality = 30;
constexpr int kQualityStep = 15;

image_t make_image(std::int64_t utime_us, const cv::Mat& like, int bytes_per_pixel, int format,
                   Bytes data) {
  image_t image{};
  image.utime = utime_us;
  image.width = like.cols;
  image.height = like.rows;
  image.row_stride = like.cols * bytes_per_pixel;
  image.pixelformat = format;
  image.size = static_cast<std::int32_t>(data.size());
  image.data = std::move(data);
  return image;
}

Bytes encode(const cv::Mat& depth_mm, ImageCoding coding) {
  return coding == ImageCoding::kPacked ? encode_packed_depth(depth_mm) : encode_depth(depth_mm);
}

images_t make_message(std::int64_t utime_us, Bytes jpeg, const cv::Mat& depth_mm, Bytes depth,
                      ImageCoding coding) {
  images_t message{};
  message.utime = utime_us;
  message.n_images = 2;
  message.image_types = {images_t::LEFT, images_t::DEPTH_MM_ZIPPED};
  if (coding == ImageCoding::kPacked) message.image_types[1] = kDepthPacked;
  message.images.push_back(
      make_image(utime_us, depth_mm, 3, image_t::PIXEL_FORMAT_MJPEG, std::move(jpeg)));
  message.images.push_back(
      make_image(utime_us, depth_mm, 2, image_t::PIXEL_FORMAT_LE_GRAY16, std::move(depth)));
  return message;
}

const image_t* find_image(const images_t& message, std::int16_t type) {
  const std::size_t n = std::min(message.images.size(), message.image_types.size());
  for (std::size_t i = 0; i < n; ++i)
    if (message.image_types[i] == type) return &message.images[i];
  return nullptr;
}

std::optional<cv::Mat> raw_colour(const image_t& image, std::string* why) {
  const bool rgb = image.pixelformat == image_t::PIXEL_FORMAT_RGB;
  if (!rgb && image.pixelformat != image_t::PIXEL_FORMAT_GRAY)
    return *why = "colour is not MJPEG, RGB or GRAY", std::nullopt;
  const std::int64_t row_bytes = std::int64_t{image.width} * (rgb ? 3 : 1);
  const std::int64_t stride = image.row_stride == 0 ? row_bytes : image.row_stride;
  if (image.width <= 0 || image.height <= 0 || image.width > kMaxImageSide ||
      image.height > kMaxImageSide || stride < row_bytes ||
      static_cast<std::int64_t>(image.data.size()) < stride * (image.height - 1) + row_bytes)
    return *why = "colour has fewer bytes than its size needs", std::nullopt;
  const cv::Mat wrapped(image.height, image.width, rgb ? CV_8UC3 : CV_8UC1,
                        const_cast<std::uint8_t*>(image.data.data()),  // only read
                        static_cast<std::size_t>(stride));
  cv::Mat bgr;
  cv::cvtColor(wrapped, bgr, rgb ? cv::COLOR_RGB2BGR : cv::COLOR_GRAY2BGR);
  return bgr;
}

}  // namespace

images_t to_message(std::int64_t utime_us, const Bytes& colour_jpeg, const cv::Mat& depth_mm,
                    ImageCoding coding) {
  return make_message(utime_us, colour_jpeg, depth_mm, encode(depth_mm, coding), coding);
}

images_t to_message(const RgbdFrame& frame, int quality, ImageCoding coding) {
  if (frame.colour_bgr.type() != CV_8UC3 || frame.colour_bgr.size() != frame.depth_mm.size())
    throw std::invalid_argument("to_message: colour and depth do not belong together");
  Bytes depth = encode(frame.depth_mm, coding);
  Bytes jpeg;
  for (;; quality = std::max(kWorstQuality, quality - kQualityStep)) {
    jpeg = encode_jpeg(frame.colour_bgr, quality, coding == ImageCoding::kPacked);
    if (jpeg.size() + depth.size() <= kMaxFrameBytes || quality <= kWorstQuality) break;
  }
  return make_message(frame.utime_us, std::move(jpeg), frame.depth_mm, std::move(depth), coding);
}

const image_t* depth_image(const images_t& message) {
  constexpr std::int16_t kKinds[] = {images_t::DEPTH_MM_ZIPPED, kDepthPacked, images_t::DEPTH_MM};
  for (const std::int16_t type : kKinds)
    if (const image_t* image = find_image(message, type)) return image;
  return nullptr;
}

std::optional<cv::Mat> decode_depth(const images_t& message, std::string* why) {
  const image_t* image = depth_image(message);
  if (image == nullptr) return *why = "there is no depth", std::nullopt;
  if (image == find_image(message, images_t::DEPTH_MM_ZIPPED))
    return decode_depth(image->data, image->width, image->height, why);
  if (image == find_image(message, kDepthPacked))
    return decode_packed_depth(image->data, image->width, image->height, why);
  return depth_from_bytes(image->data, image->width, image->height, why);
}

std::optional<RgbdFrame> from_message(const images_t& message, std::string* why) {
  const image_t* colour = find_image(message, images_t::LEFT);
  if (colour == nullptr) return *why = "there is no LEFT image", std::nullopt;
  const auto bgr = colour->pixelformat == image_t::PIXEL_FORMAT_MJPEG
                       ? decode_jpeg(colour->data, colour->width, colour->height, why)
                       : raw_colour(*colour, why);
  if (!bgr) return std::nullopt;
  RgbdFrame frame;
  frame.utime_us = message.utime;
  frame.colour_bgr = *bgr;
  const image_t* image = depth_image(message);
  if (image == nullptr) {
    frame.depth_mm = cv::Mat::zeros(bgr->size(), CV_16UC1);
    return frame;
  }
  if (image->width != bgr->cols || image->height != bgr->rows)
    return *why = "depth and colour differ in size", std::nullopt;
  const auto depth_mm = decode_depth(message, why);
  if (!depth_mm) return std::nullopt;
  frame.depth_mm = *depth_mm;
  return frame;
}

}  // namespace fusion_slam
