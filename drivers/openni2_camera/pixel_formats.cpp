#include "drivers/openni2_camera/pixel_formats.hpp"

#include <opencv2/imgproc.hpp>

#include "libs/camera/image_codec.hpp"

namespace fusion_slam {
namespace {

std::string size_text(int width_px, int height_px) {
  return std::to_string(width_px) + " x " + std::to_string(height_px);
}

int bytes_per_pixel(PixelFormat format) {
  switch (format) {
    case PixelFormat::kRgb:
      return 3;
    case PixelFormat::kGrey:
    case PixelFormat::kJpeg:
      return 1;
    default:
      return 2;
  }
}

int matrix_type(PixelFormat format) {
  switch (format) {
    case PixelFormat::kRgb:
      return CV_8UC3;
    case PixelFormat::kUyvy:
    case PixelFormat::kYuyv:
      return CV_8UC2;
    case PixelFormat::kDepthMm:
    case PixelFormat::kDepth100um:
      return CV_16UC1;
    default:
      return CV_8UC1;
  }
}

cv::Mat as_ours(const cv::Mat& image, PixelFormat format) {
  cv::Mat out;
  switch (format) {
    case PixelFormat::kRgb:
      cv::cvtColor(image, out, cv::COLOR_RGB2BGR);
      break;
    case PixelFormat::kUyvy:
      cv::cvtColor(image, out, cv::COLOR_YUV2BGR_UYVY);
      break;
    case PixelFormat::kYuyv:
      cv::cvtColor(image, out, cv::COLOR_YUV2BGR_YUYV);
      break;
    case PixelFormat::kGrey:
      cv::cvtColor(image, out, cv::COLOR_GRAY2BGR);
      break;
    case PixelFormat::kDepth100um:
      out.create(image.size(), CV_16UC1);
      for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u)
          out.at<std::uint16_t>(v, u) =
              static_cast<std::uint16_t>((image.at<std::uint16_t>(v, u) + 5) / 10);
      break;
    default:
      out = image.clone();
  }
  return out;
}

}  // namespace

std::optional<cv::Mat> read_image(const RawImage& raw, cv::Size promised, std::string* why) {
  if (raw.width_px != promised.width || raw.height_px != promised.height)
    return *why = "it is " + size_text(raw.width_px, raw.height_px) + " and not " +
                  size_text(promised.width, promised.height) + " as the mode says",
           std::nullopt;
  if (raw.format == PixelFormat::kJpeg)
    return decode_jpeg(Bytes(raw.bytes, raw.bytes + raw.size_bytes), raw.width_px, raw.height_px,
                       why);
  const auto row = static_cast<std::size_t>(raw.width_px) *
                   static_cast<std::size_t>(bytes_per_pixel(raw.format));
  const std::size_t stride =
      raw.stride_bytes == 0 ? row : static_cast<std::size_t>(std::max(0, raw.stride_bytes));
  const std::size_t need = stride * static_cast<std::size_t>(raw.height_px - 1) + row;
  if (stride < row || raw.size_bytes < need || raw.bytes == nullptr)
    return *why = "it has " + std::to_string(raw.size_bytes) + " bytes instead of " +
                  std::to_string(need) + ": damaged on the way",
           std::nullopt;
  const cv::Mat wrapped(raw.height_px, raw.width_px, matrix_type(raw.format),
                        const_cast<std::uint8_t*>(raw.bytes), stride);  // only read
  return as_ours(wrapped, raw.format);
}

}  // namespace fusion_slam
