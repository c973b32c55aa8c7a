#include "logplayer/calibrate/read_drive.hpp"

#include <cmath>
#include <optional>
#include <stdexcept>

#include "bot_core/images_t.hpp"
#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "libs/calibration/depth_rays.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "services/lidar_mapper/lidar_mapper.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kBetweenFrames_us = 180'000;
constexpr std::int64_t kSweep_us = 250'000;  // odometry up to a sweep's end is known
constexpr std::size_t kMostFrames = 1000;    // 250 KB each

template <class Message>
std::optional<Message> decode(const LogEvent& event) {
  Message message;
  if (message.decode(event.data.data(), 0, static_cast<int>(event.data.size())) < 0)
    return std::nullopt;
  return message;
}

bool read_models(const std::filesystem::path& log, CalibrationDrive* drive) {
  LogReader reader(log);
  bool robot = false;
  bool camera = false;
  std::string why;
  for (LogEvent event; !(robot && camera) && reader.next(&event);) {
    if (!robot && event.channel == "ROBOT_MODEL")
      if (const auto message = decode<robot_model_t>(event))
        if (const auto model = from_message(*message, &why)) {
          drive->robot = *model;
          robot = true;
        }
    if (!camera && event.channel == "CAMERA_MODEL")
      if (const auto message = decode<camera_model_t>(event))
        if (const auto model = from_message(*message, &why)) {
          drive->camera = *model;
          camera = true;
        }
  }
  if (!robot)
    throw std::runtime_error(log.string() + " has no ROBOT_MODEL: record it with the drive");
  return camera;
}

// A LiDAR mounted upside down measures the other way round: as if it stood upright.
void stand_upright(const RobotModel& robot, LaserScan* scan) {
  if (robot.T_base_lidar.linear()(2, 2) > 0.0) return;
  scan->rad0 = -scan->rad0;
  scan->radstep = -scan->radstep;
}

// The LiDAR's own motion by the mapper, as if the LiDAR were the robot: where it sits is what is
// looked for. The wheels, by way of the mounting on paper, only say how fast it moves during a
// sweep.
void find_lidar_path(CalibrationDrive* drive) {
  RobotModel alone = drive->robot;
  alone.T_base_lidar = SE3::Identity();
  LidarMapper mapper(alone);
  const SE2 T_base_lidar = to_se2(drive->robot.T_base_lidar);
  const std::vector<std::int64_t>& wheel_us = drive->odometry.times_us();
  std::size_t next = 0;
  for (const LaserScan& scan : drive->scans) {
    for (; next < wheel_us.size() && wheel_us[next] <= scan.utime_us + kSweep_us; ++next)
      mapper.add_odometry(wheel_us[next],
                          drive->odometry.at(static_cast<double>(wheel_us[next])) * T_base_lidar);
    const MapperOutput out = mapper.add_scan(scan);
    if (out.pose && out.pose->state != MatchState::kLost)
      drive->lidar.add(out.pose->utime_us, out.pose->T_odom_base);
  }
}

}  // namespace

CalibrationDrive read_drive(const std::filesystem::path& log,
                            const std::function<void(double)>& progress) {
  CalibrationDrive drive;
  const bool camera = read_models(log, &drive);
  const DepthSampler sampler(drive.camera);
  LogReader reader(log);
  std::int64_t next_frame_us = INT64_MIN;
  std::int64_t n_events = 0;
  std::string why;
  for (LogEvent event; reader.next(&event);) {
    if (progress && ++n_events % 200 == 0)
      progress(static_cast<double>(reader.offset_bytes()) /
               static_cast<double>(reader.size_bytes()));
    if (event.channel == "LIDAR") {
      const auto message = decode<bot_core::planar_lidar_t>(event);
      auto scan = message ? from_message(*message, &why) : std::nullopt;
      if (!scan) continue;
      stand_upright(drive.robot, &*scan);
      drive.scans.push_back(std::move(*scan));
    } else if (event.channel == "ODOMETRY") {
      const auto message = decode<bot_core::pose_t>(event);
      const auto pose = message ? from_message(*message) : std::nullopt;
      if (pose) drive.odometry.add(message->utime, to_se2(*pose));
    } else if (event.channel == "CAMERA" && camera && drive.frames.size() < kMostFrames) {
      const auto message = decode<bot_core::images_t>(event);
      const bot_core::image_t* image = message ? depth_image(*message) : nullptr;
      if (image == nullptr || message->utime < next_frame_us) continue;
      next_frame_us = message->utime + kBetweenFrames_us;
      const auto depth = decode_depth(*message, &why);
      if (depth) drive.frames.push_back(sampler.sample(image->utime, *depth));
    }
  }
  find_lidar_path(&drive);
  drive.robot.has_camera = drive.robot.has_camera && !drive.frames.empty();
  drive.robot.has_lidar = drive.robot.has_lidar && drive.lidar.size() >= 2;
  if (!drive.robot.has_camera && !drive.robot.has_lidar)
    throw std::runtime_error(log.string() + " has neither CAMERA (with CAMERA_MODEL) nor LIDAR");
  return drive;
}

}  // namespace fusion_slam
