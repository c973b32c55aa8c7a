// Directories of colour and depth images: 7-Scenes and TUM RGB-D. Opening lists the frames; images
// are read one by one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/camera/depth_registration.hpp"
#include "libs/camera/image_codec.hpp"
#include "libs/camera/rgbd_frame.hpp"
#include "libs/datasets/trajectory_file.hpp"

namespace fusion_slam {

struct RgbdEntry {
  std::int64_t utime_us = 0;  // of the colour image
  std::int64_t depth_utime_us = 0;
  std::filesystem::path colour;
  std::filesystem::path depth;
};

struct RgbdDataset {
  std::string camera_name;  // what the intrinsics belong to, for people
  CameraModel camera;  // of the colour image; only size, focal lengths, centre, distortion and rate
                       // are the data set's
  std::optional<DepthRegistration>
      registration;  // how to bring depth to colour; none: it is registered already
  double depth_units_per_mm = 1.0;
  std::vector<RgbdEntry> entries;        // utime strictly increasing
  std::vector<ReferencePose> reference;  // T_world_camera of the colour camera's optical frame
  Skipped skipped;                       // by frame number or line
};

// 7-Scenes (Shotton et al. 2013): frame-NNNNNN.color.png or .jpg, .depth.png (mm, depth camera),
// .pose.txt (4x4, depth camera to world). There are no time stamps: frame N gets kSevenScenesEpoch
// + N / 30 s. The poses are moved to the colour camera. `directory` or its sub-directory data/
// holds the frames. Throws DatasetError when there are none.
RgbdDataset open_seven_scenes(const std::filesystem::path& directory);
inline constexpr std::int64_t kSevenScenesEpochUs =
    1'000'000'000'000'000;  // 2001-09-09 01:46:40 UTC

// TUM RGB-D (Sturm et al. 2012): rgb.txt, depth.txt, groundtruth.txt (optional). Each colour image
// gets the depth image that is nearest in time, within 20 ms, each depth image used once.
// Intrinsics are the published ones of freiburg1, 2 or 3, by the name in rgb.txt's header or of the
// directory; else those of the ROS driver. Throws DatasetError when nothing is usable.
RgbdDataset open_tum_rgbd(const std::filesystem::path& directory);

// The images of entry i, depth in mm registered to colour; or nothing with a reason.
std::optional<RgbdFrame> load_frame(const RgbdDataset& dataset, std::size_t i, std::string* why);
// Only the depth of it, for who sends the colour file's own bytes.
std::optional<cv::Mat> load_depth_mm(const RgbdDataset& dataset, std::size_t i, std::string* why);
// The colour file's bytes when it is a JPEG of the data set's size.
std::optional<Bytes> load_colour_jpeg(const RgbdDataset& dataset, std::size_t i);

}  // namespace fusion_slam
