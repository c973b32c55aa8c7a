#include "drivers/simulator/recording.hpp"

#include <algorithm>
#include <deque>
#include <future>
#include <utility>

#include "drivers/simulator/lidar_sensor.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/eventlog/writer.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

constexpr double kOdometryHz = 50.0;
constexpr double kModelHz = 1.0;

// In the order in which messages of one moment are written.
enum class Channel { kRobotModel, kCameraModel, kGroundTruth, kOdometry, kLidar, kCamera };

struct Due {
  std::int64_t utime_us;
  Channel channel;
  std::int64_t index;  // 0, 1, 2 ... of its channel
};

template <class Message>
Bytes encode(const Message& message) {
  Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

double seconds_of(std::int64_t utime_us) { return 1e-6 * static_cast<double>(utime_us - kEpochUs); }

std::vector<Due> schedule(const SimulationOptions& options) {
  std::vector<Due> all;
  const auto add = [&](Channel channel, double rate_hz, double last_s) {
    for (std::int64_t i = 0; static_cast<double>(i) / rate_hz <= last_s; ++i)
      all.push_back({kEpochUs + std::llround(1e6 * static_cast<double>(i) / rate_hz), channel, i});
  };
  add(Channel::kRobotModel, kModelHz, options.seconds);
  add(Channel::kCameraModel, kModelHz, options.seconds);
  add(Channel::kGroundTruth, options.camera_hz, options.seconds);
  add(Channel::kOdometry, kOdometryHz, options.seconds);
  add(Channel::kLidar, kLidarRateHz, options.seconds - 1.0 / kLidarRateHz);  // whole sweeps only
  add(Channel::kCamera, options.camera_hz, options.seconds);
  std::sort(all.begin(), all.end(), [](const Due& a, const Due& b) {
    return std::pair(a.utime_us, a.channel) < std::pair(b.utime_us, b.channel);
  });
  return all;
}

// Frames in order, rendered ahead by several threads.
class FrameQueue {
 public:
  FrameQueue(std::vector<Due> frames, int threads, std::function<Bytes(const Due&)> make)
      : frames_(std::move(frames)), make_(std::move(make)) {
    for (int i = 0; i < std::max(1, threads); ++i) start_next();
  }
  Bytes pop() {
    Bytes bytes = ahead_.front().get();
    ahead_.pop_front();
    start_next();
    return bytes;
  }

 private:
  void start_next() {
    if (next_ == frames_.size()) return;
    ahead_.push_back(std::async(std::launch::async, make_, frames_[next_]));
    ++next_;
  }
  std::vector<Due> frames_;
  std::function<Bytes(const Due&)> make_;
  std::size_t next_ = 0;
  std::deque<std::future<Bytes>> ahead_;  // last: its destructor waits for what uses the others
};

const char* name_of(Channel channel) {
  constexpr const char* kNames[] = {"ROBOT_MODEL", "CAMERA_MODEL", "GROUND_TRUTH",
                                    "ODOMETRY",    "LIDAR",        "CAMERA"};
  return kNames[static_cast<std::size_t>(channel)];
}

}  // namespace

RobotModel simulated_robot() {
  RobotModel robot;
  robot.name = "simulated-robot";
  robot.has_lidar = robot.has_camera = robot.has_odometry = true;
  robot.T_base_lidar.translation() = Eigen::Vector3d(0.0, 0.0, 0.20);
  robot.T_base_camera.translation() = Eigen::Vector3d(0.10, 0.0, 0.35);
  robot.T_base_camera.linear() = optical_to_body();
  robot.lidar.rate_hz = kLidarRateHz;
  robot.lidar.beam_period_s = 1.0 / (kLidarRateHz * kBeams);
  return robot;
}

CameraModel simulated_camera(double rate_hz) {
  CameraModel camera;  // 640x480, c = (319.5, 239.5), depth noise of the Astra
  camera.fx_px = camera.fy_px = 570.0;
  camera.depth_min_m = 0.6;
  camera.depth_max_m = 8.0;
  camera.rate_hz = rate_hz;
  return camera;
}

RecordingSummary write_recording(const World& world, const SimulationOptions& options,
                                 const std::filesystem::path& path,
                                 const std::function<void(std::int64_t, std::int64_t)>& progress) {
  LogWriter log(path);
  const Drive drive(world.route_m, world.limits, options.seconds + 1.0);
  const auto odometry = wheel_odometry(drive, WheelNoise{}, options.seed, options.noise);
  const Scene scene(world.boxes);
  const RobotModel robot = simulated_robot();
  const CameraModel camera = simulated_camera(options.camera_hz);
  const CameraRenderer renderer(scene, world.lighting, camera);
  const NoisyCamera noisy(camera, CameraNoise{}, options.seed);

  const std::vector<Due> all = schedule(options);
  std::vector<Due> frames;
  std::copy_if(all.begin(), all.end(), std::back_inserter(frames),
               [](const Due& due) { return due.channel == Channel::kCamera; });
  FrameQueue queue(frames, options.threads, [&](const Due& due) {
    const SE3 T_world_base = to_se3(drive.T_world_base(seconds_of(due.utime_us)));
    const RenderedFrame ideal = renderer.render(T_world_base * robot.T_base_camera);
    return encode(to_message(noisy.expose(ideal, due.index, due.utime_us, options.noise)));
  });

  const auto message_of = [&](const Due& due) {
    const double time_s = seconds_of(due.utime_us);
    const auto with_seq = [&](auto message) {
      message.seq = due.index + 1;
      return encode(message);
    };
    switch (due.channel) {
      case Channel::kRobotModel:
        return with_seq(to_message(robot, due.utime_us));
      case Channel::kCameraModel:
        return with_seq(to_message(camera, due.utime_us));
      case Channel::kGroundTruth:
        return encode(to_pose_message(to_se3(drive.T_world_base(time_s)), due.utime_us));
      case Channel::kOdometry: {
        const auto step = static_cast<std::size_t>(std::llround(time_s / Drive::kStepS));
        return encode(to_pose_message(to_se3(odometry[step]), due.utime_us));
      }
      case Channel::kLidar: {
        const auto pose_after = [&](double s) { return drive.T_world_base(time_s + s); };
        return encode(to_message(sweep(scene, robot, LidarNoise{}, pose_after, due.utime_us,
                                       options.seed, due.index, options.noise)));
      }
      case Channel::kCamera:
        return queue.pop();
    }
    return Bytes{};
  };
  for (const Due& due : all) {
    log.write(due.utime_us, name_of(due.channel), message_of(due));
    if (due.channel == Channel::kCamera && progress)
      progress(due.index + 1, static_cast<std::int64_t>(frames.size()));
  }
  log.close();
  return {log.n_events(), static_cast<std::int64_t>(frames.size()), log.size_bytes(),
          drive.lap_s()};
}

}  // namespace fusion_slam
