#include <memory>

#include "libs/camera_messages/images.hpp"
#include "libs/datasets/rgbd_dataset.hpp"
#include "logplayer/import/sources.hpp"

namespace fusion_slam {
namespace {

// The colour file's own bytes where they are a JPEG and small enough: nothing is lost by encoding
// twice.
std::string write_frame(const RgbdDataset& dataset, std::size_t i, LogOutput* out) {
  const std::int64_t utime_us = dataset.entries[i].utime_us;
  std::string why;
  if (const auto jpeg = load_colour_jpeg(dataset, i)) {
    const auto depth_mm = load_depth_mm(dataset, i, &why);
    if (!depth_mm) return why;
    const auto message = to_message(utime_us, *jpeg, *depth_mm);
    if (message.images[0].data.size() + message.images[1].data.size() <= kMaxFrameBytes) {
      out->write(utime_us, "CAMERA", message);
      return "";
    }
  }
  const auto frame = load_frame(dataset, i, &why);
  if (!frame) return why;
  out->write(utime_us, "CAMERA", to_message(*frame));
  return "";
}

Timeline rgbd_source(RgbdDataset opened, RobotConfig* config) {
  const auto dataset = std::make_shared<const RgbdDataset>(std::move(opened));
  CameraModel& camera = config->camera;  // depth range and noise stay the sensor model's
  camera.width_px = dataset->camera.width_px;
  camera.height_px = dataset->camera.height_px;
  camera.fx_px = dataset->camera.fx_px;
  camera.fy_px = dataset->camera.fy_px;
  camera.cx_px = dataset->camera.cx_px;
  camera.cy_px = dataset->camera.cy_px;
  camera.distortion = dataset->camera.distortion;
  camera.rate_hz = dataset->camera.rate_hz;
  Timeline timeline;
  timeline.skipped = dataset->skipped;
  timeline.place_name = "frame or line";
  timeline.notes.push_back("camera intrinsics: " + dataset->camera_name);
  for (std::size_t i = 0; i < dataset->entries.size(); ++i)
    timeline.events.push_back(
        {dataset->entries[i].utime_us, EventKind::kCamera,
         [dataset, i](LogOutput& out) { return write_frame(*dataset, i, &out); }});
  const SE3 T_camera_reference =
      config->robot.T_base_camera.inverse() * config->robot.T_base_reference();
  for (const ReferencePose& p : dataset->reference)
    timeline.add_pose(EventKind::kGroundTruth, "GROUND_TRUTH", p.utime_us,
                      p.T_world_reference * T_camera_reference);
  return timeline;
}

}  // namespace

Timeline seven_scenes_source(const ImportOptions& options, RobotConfig* config) {
  return rgbd_source(open_seven_scenes(options.source), config);
}

Timeline tum_source(const ImportOptions& options, RobotConfig* config) {
  return rgbd_source(open_tum_rgbd(options.source), config);
}

}  // namespace fusion_slam
