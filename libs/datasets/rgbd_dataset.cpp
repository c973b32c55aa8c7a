#include "libs/datasets/rgbd_dataset.hpp"

#include <cmath>
#include <fstream>
#include <iterator>

#include <opencv2/imgcodecs.hpp>

namespace fusion_slam {
namespace {

constexpr std::uint16_t kNoReading = 65535;  // 7-Scenes' mark of a pixel without depth
constexpr std::streamoff kMaxImageFileBytes = 64 << 20;

std::optional<Bytes> read_bytes(const std::filesystem::path& path, std::string* why) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file ? static_cast<std::streamoff>(file.tellg()) : -1;
  if (size <= 0 || size > kMaxImageFileBytes)
    return *why = path.filename().string() + " is missing, empty or over 64 MB", std::nullopt;
  Bytes bytes(static_cast<std::size_t>(size));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.data()), size);
  if (!file) return *why = path.filename().string() + " cannot be read", std::nullopt;
  return bytes;
}

std::optional<cv::Mat> read_image(const std::filesystem::path& path, int flags, int type,
                                  const CameraModel& camera, std::string* why) {
  const auto bytes = read_bytes(path, why);
  if (!bytes) return std::nullopt;
  cv::Mat image;
  try {
    image = cv::imdecode(*bytes, flags);
  } catch (const cv::Exception&) {
    image.release();
  }
  const std::string name = path.filename().string();
  if (image.empty()) return *why = name + " is not an image or damaged", std::nullopt;
  if (image.type() != type) return *why = name + " is not of the expected pixel type", std::nullopt;
  if (image.cols != camera.width_px || image.rows != camera.height_px)
    return *why = name + " is " + std::to_string(image.cols) + " x " + std::to_string(image.rows),
           std::nullopt;
  return image;
}

void to_millimetres(double units_per_mm, cv::Mat* depth) {
  for (int v = 0; v < depth->rows; ++v) {
    auto* row = depth->ptr<std::uint16_t>(v);
    for (int u = 0; u < depth->cols; ++u)
      row[u] =
          row[u] == kNoReading ? 0 : static_cast<std::uint16_t>(std::lround(row[u] / units_per_mm));
  }
}

}  // namespace

std::optional<cv::Mat> load_depth_mm(const RgbdDataset& dataset, std::size_t i, std::string* why) {
  const auto& registration = dataset.registration;
  const CameraModel& camera = registration ? registration->depth_camera : dataset.camera;
  auto depth = read_image(dataset.entries[i].depth, cv::IMREAD_UNCHANGED, CV_16UC1, camera, why);
  if (!depth) return std::nullopt;
  to_millimetres(dataset.depth_units_per_mm, &*depth);
  return registration ? register_depth(*depth, *registration) : *depth;
}

std::optional<Bytes> load_colour_jpeg(const RgbdDataset& dataset, std::size_t i) {
  std::string why;
  auto bytes = read_bytes(dataset.entries[i].colour, &why);
  const auto size = bytes ? jpeg_size(*bytes) : std::nullopt;
  if (!size || *size != cv::Size(dataset.camera.width_px, dataset.camera.height_px))
    return std::nullopt;
  return bytes;
}

std::optional<RgbdFrame> load_frame(const RgbdDataset& dataset, std::size_t i, std::string* why) {
  const auto colour =
      read_image(dataset.entries[i].colour, cv::IMREAD_COLOR, CV_8UC3, dataset.camera, why);
  if (!colour) return std::nullopt;
  const auto depth = load_depth_mm(dataset, i, why);
  if (!depth) return std::nullopt;
  return RgbdFrame{dataset.entries[i].utime_us, *colour, *depth};
}

}  // namespace fusion_slam
