#include "libs/log_export/tum_export.hpp"

#include <cstdio>
#include <fstream>
#include <set>

#include <opencv2/imgcodecs.hpp>

#include "bot_core/pose_t.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/messages/convert.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

constexpr int kUnitsPerMm = 5;
constexpr int kMostUnits = 65535;
constexpr int kPngLevel = 1;  // of zlib: 9 takes ten times as long for a tenth less

using bot_core::images_t;

void write_bytes(const fs::path& file, const Bytes& bytes) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw ExportError(file.string() + ": cannot be written; is the disk full?");
}

void write_png(const fs::path& file, const cv::Mat& image) {
  Bytes bytes;
  cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, kPngLevel});
  write_bytes(file, bytes);
}

cv::Mat tum_depth(const cv::Mat& depth_mm, std::int64_t* too_far) {
  cv::Mat units(depth_mm.size(), CV_16UC1);
  for (int v = 0; v < units.rows; ++v)
    for (int u = 0; u < units.cols; ++u) {
      int value = kUnitsPerMm * depth_mm.at<std::uint16_t>(v, u);
      if (value > kMostUnits) {
        value = 0;
        ++*too_far;
      }
      units.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(value);
    }
  return units;
}

std::int64_t stamp_of(const images_t& message, std::int16_t type, std::int64_t otherwise) {
  for (std::size_t i = 0; i < message.images.size() && i < message.image_types.size(); ++i)
    if (message.image_types[i] == type && message.images[i].utime > 0)
      return message.images[i].utime;
  return otherwise;
}

const Bytes* jpeg_of(const images_t& message) {
  for (std::size_t i = 0; i < message.images.size() && i < message.image_types.size(); ++i)
    if (message.image_types[i] == images_t::LEFT &&
        message.images[i].pixelformat == bot_core::image_t::PIXEL_FORMAT_MJPEG)
      return &message.images[i].data;
  return nullptr;
}

std::string camera_comment(const std::optional<CameraModel>& camera) {
  if (!camera) return "";
  char text[320];
  const auto& k = camera->distortion;
  std::snprintf(text, sizeof text,
                "# camera: fx %.9g fy %.9g cx %.9g cy %.9g k1 %.9g k2 %.9g p1 %.9g p2 %.9g k3 %.9g "
                "width %d height %d\n",
                camera->fx_px, camera->fy_px, camera->cx_px, camera->cy_px, k[0], k[1], k[2], k[3],
                k[4], camera->width_px, camera->height_px);
  return text;
}

std::string pose_line(std::int64_t utime_us, const SE3& T) {
  const bot_core::pose_t p = to_pose_message(T, utime_us);  // for its normal form of a quaternion
  char text[256];
  std::snprintf(text, sizeof text, " %.6f %.6f %.6f %.8f %.8f %.8f %.8f\n", p.pos[0], p.pos[1],
                p.pos[2], p.orientation[1], p.orientation[2], p.orientation[3], p.orientation[0]);
  return seconds_text(utime_us) + text;
}

class TumWriter {
 public:
  TumWriter(const fs::path& log, fs::path directory, const TumExportOptions& options)
      : models_(read_models(log)), options_(options), directory_(std::move(directory)) {
    fs::create_directories(directory_ / "rgb");
    fs::create_directories(directory_ / "depth");
    T_reference_camera_ = models_.robot.T_base_reference().inverse() * models_.robot.T_base_camera;
  }

  void handle(const LogEvent& event) {
    if (event.channel == "CAMERA") on_camera(event);
    if (event.channel == "GROUND_TRUTH") on_pose(event);
  }

  void finish(const fs::path& log) {
    if (rgb_.empty())
      throw ExportError(log.string() + ": holds no usable CAMERA frame; TUM RGB-D is for cameras");
    const std::string origin = "# from " + log.filename().string() + " by fusion-slam export\n";
    write_list("rgb.txt", "# color images\n" + origin + camera_comment(models_.camera), rgb_);
    write_list("depth.txt", "# depth maps\n" + origin, depth_);
    if (!poses_.empty())
      write_list("groundtruth.txt",
                 "# ground truth trajectory\n" + origin + "# timestamp tx ty tz qx qy qz qw\n",
                 poses_);
    summary.written["colour images"] = static_cast<std::int64_t>(rgb_.size());
    summary.written["depth images"] = static_cast<std::int64_t>(depth_.size());
    summary.written["poses"] = static_cast<std::int64_t>(poses_.size());
    if (too_far_ > 0) summary.skipped["depth pixels beyond 13.1 m"] = too_far_;
  }

  ExportSummary summary;

 private:
  void on_camera(const LogEvent& event) {
    const auto message = decode_event<images_t>(event);
    std::string why = "CAMERA: not a message of its type";
    const auto frame = message ? from_message(*message, &why) : std::nullopt;
    if (!frame) {
      ++summary.skipped[why];
      return;
    }
    const std::int64_t colour_us = stamp_of(*message, images_t::LEFT, message->utime);
    const bot_core::image_t* image = depth_image(*message);
    const std::int64_t depth_us = image != nullptr && image->utime > 0 ? image->utime : colour_us;
    if (rgb_.count(colour_us) != 0 || depth_.count(depth_us) != 0) {
      ++summary.skipped["CAMERA: two frames of one time"];
      return;
    }
    const Bytes* jpeg = options_.keep_jpeg ? jpeg_of(*message) : nullptr;
    const std::string rgb = "rgb/" + seconds_text(colour_us) + (jpeg != nullptr ? ".jpg" : ".png");
    const std::string depth = "depth/" + seconds_text(depth_us) + ".png";
    if (jpeg != nullptr)
      write_bytes(directory_ / rgb, *jpeg);
    else
      write_png(directory_ / rgb, frame->colour_bgr);
    write_png(directory_ / depth, tum_depth(frame->depth_mm, &too_far_));
    rgb_[colour_us] = seconds_text(colour_us) + " " + rgb + "\n";
    depth_[depth_us] = seconds_text(depth_us) + " " + depth + "\n";
  }

  void on_pose(const LogEvent& event) {
    const auto message = decode_event<bot_core::pose_t>(event);
    const auto T_world_reference = message ? from_message(*message) : std::nullopt;
    if (T_world_reference)
      poses_[message->utime] = pose_line(message->utime, *T_world_reference * T_reference_camera_);
    else
      ++summary.skipped["GROUND_TRUTH: not a pose"];
  }

  void write_list(const char* name, const std::string& head,
                  const std::map<std::int64_t, std::string>& lines) const {
    std::string text = head;
    for (const auto& [utime_us, line] : lines) text += line;
    write_bytes(directory_ / name, Bytes(text.begin(), text.end()));
  }

  LogModels models_;
  TumExportOptions options_;
  fs::path directory_;
  SE3 T_reference_camera_ = SE3::Identity();
  std::map<std::int64_t, std::string> rgb_, depth_, poses_;  // lines by time
  std::int64_t too_far_ = 0;
};

}  // namespace

ExportSummary export_tum(const fs::path& log, const fs::path& directory,
                         const TumExportOptions& options,
                         const std::function<void(double)>& progress) {
  std::error_code error;
  if (fs::exists(directory, error) && !fs::is_empty(directory, error))
    throw ExportError(directory.string() + ": is not empty; give another directory");
  fs::path partial = directory.lexically_normal();
  if (!partial.has_filename()) partial = partial.parent_path();
  const fs::path whole = partial;
  partial += ".partial";
  try {
    fs::remove_all(partial);
    TumWriter writer(log, partial, options);
    for_each_event(
        log, [&](const LogEvent& event) { writer.handle(event); }, progress);
    writer.finish(log);
    fs::remove(whole);
    fs::rename(partial, whole);
    return writer.summary;
  } catch (const fs::filesystem_error& failure) {
    fs::remove_all(partial, error);
    throw ExportError(std::string(failure.what()) + "; may you write there?");
  } catch (...) {
    fs::remove_all(partial, error);
    throw;
  }
}

}  // namespace fusion_slam
