#include <array>
#include <map>

#include "libs/datasets/rgbd_dataset.hpp"

namespace fusion_slam {
namespace {

constexpr double kRateHz = 30.0;

// Kinect v1. Depth: the intrinsics published with the data set. Colour: it publishes none. Nominal
// values for this camera are f about 525 and 2.5 cm between the cameras (colour on the right of
// depth); aligning depth edges with colour edges, without the reference poses, confirms 2.5 cm and
// gives f = 528, c = (320, 239), the same in each quarter of the recording within 1.5 px
// (docs/import.md).
DepthRegistration kinect_registration() {
  DepthRegistration registration;
  registration.depth_camera.fx_px = registration.depth_camera.fy_px = 585.0;
  registration.depth_camera.cy_px = 240.0;
  registration.colour_camera.fx_px = registration.colour_camera.fy_px = 528.0;
  registration.colour_camera.cy_px = 239.0;
  for (CameraModel* camera : {&registration.depth_camera, &registration.colour_camera}) {
    camera->cx_px = 320.0;
    camera->rate_hz = kRateHz;
  }
  registration.T_colour_depth.translation().x() = -0.025;
  return registration;
}

// 4x4, row by row; the last row is 0 0 0 1.
std::optional<SE3> read_matrix(const std::filesystem::path& path, std::string* why) {
  std::string text;
  try {
    text = read_text_file(path);
  } catch (const DatasetError&) {
    return *why = "pose file missing or unreadable", std::nullopt;
  }
  std::string_view rest = text;
  Eigen::Matrix4d m;
  for (int i = 0; i < 16; ++i) {
    const auto value = parse_number(next_word(&rest));
    if (!value) return *why = "pose is not a 4x4 matrix", std::nullopt;
    m(i / 4, i % 4) = *value;
  }
  const Eigen::Matrix3d R = m.topLeftCorner<3, 3>();
  const double error = (R * R.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(error <= 0.01) || !(R.determinant() > 0.0))  // also when they overflow to NaN
    return *why = "pose is not a rigid motion", std::nullopt;
  SE3 T = SE3::Identity();
  T.linear() = Eigen::Quaterniond(R).normalized().toRotationMatrix();
  T.translation() = m.topRightCorner<3, 1>();
  return T;
}

// Number of "frame-NNNNNN.<suffix>", or nothing.
std::optional<std::int64_t> frame_number(const std::string& name) {
  const std::size_t dot = name.find('.');
  if (name.rfind("frame-", 0) != 0 || dot == std::string::npos) return std::nullopt;
  const auto number = parse_integer(std::string_view(name).substr(6, dot - 6));
  return number && *number >= 0 && *number < 100'000'000 ? number : std::nullopt;
}

std::map<std::int64_t, std::filesystem::path> colour_files(const std::filesystem::path& directory) {
  std::map<std::int64_t, std::filesystem::path> files;
  for (const auto& file : std::filesystem::directory_iterator(directory)) {
    const std::string name = file.path().filename().string();
    const std::string end = name.substr(std::min(name.size(), name.find('.')));
    const auto number = frame_number(name);
    if (number && (end == ".color.jpg" || end == ".color.png")) files[*number] = file.path();
  }
  return files;
}

}  // namespace

RgbdDataset open_seven_scenes(const std::filesystem::path& directory) {
  if (!std::filesystem::is_directory(directory))
    throw DatasetError(directory.string() +
                       ": is not a directory; give the one with frame-000000.color.png");
  const auto data = directory / "data";
  const auto folder = std::filesystem::is_directory(data) ? data : directory;
  RgbdDataset dataset;
  dataset.camera_name = "7-Scenes Kinect v1";
  dataset.registration = kinect_registration();
  dataset.camera = dataset.registration->colour_camera;
  const SE3 T_depth_colour = dataset.registration->T_colour_depth.inverse();
  for (const auto& [number, colour] : colour_files(folder)) {
    const std::string name = colour.filename().string();
    const std::string stem = name.substr(0, name.find('.'));
    RgbdEntry entry;
    entry.utime_us = entry.depth_utime_us = kSevenScenesEpochUs + number * 1'000'000 / 30;
    entry.colour = colour;
    entry.depth = folder / (stem + ".depth.png");
    if (!std::filesystem::exists(entry.depth)) {
      dataset.skipped.add(number, "frame without depth image");
      continue;
    }
    std::string why;
    const auto T_world_depth = read_matrix(folder / (stem + ".pose.txt"), &why);
    if (T_world_depth)
      dataset.reference.push_back({entry.utime_us, *T_world_depth * T_depth_colour});
    else
      dataset.skipped.add(number, why);
    dataset.entries.push_back(entry);
  }
  if (dataset.entries.empty())
    throw DatasetError(
        folder.string() +
        ": no frame-NNNNNN.color.png (or .jpg) with its .depth.png; is this a 7-Scenes sequence?");
  return dataset;
}

}  // namespace fusion_slam
