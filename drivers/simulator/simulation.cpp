#include "drivers/simulator/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "drivers/simulator/camera_renderer.hpp"
#include "drivers/simulator/random.hpp"
#include "drivers/simulator/random_route.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

constexpr double kOdometryHz = 50.0;
constexpr double kModelHz = 1.0;
constexpr double kDefaultSeconds = 60.0;
constexpr double kTwistStepS = 0.001;
constexpr int kPractiseFrames = 24;
constexpr double kMostJitter = 0.4;  // of a period: stamps stay in order
constexpr std::uint64_t kCameraStampStream = 50;
constexpr std::uint64_t kDepthStampStream = 51;
constexpr std::uint64_t kLidarStampStream = 52;

template <class Message>
Bytes encode(const Message& message) {
  Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

std::int64_t us(double seconds) { return std::llround(1e6 * seconds); }

RobotModel robot_for(const std::optional<Route>& route, const SimulationOptions& options) {
  RobotModel robot = simulated_robot();
  robot.lidar.rate_hz = options.lidar_hz;
  robot.lidar.beam_period_s =
      options.noise.lidar.with_sweep ? 1.0 / (options.lidar_hz * kBeams) : 0.0;
  if (route && route->camera) {
    const RouteCamera& c = *route->camera;
    robot.T_base_camera = from_xyz_rpy(c.x_m, 0.0, c.z_m, 0.0, c.pitch_rad, 0.0);
    robot.T_base_camera.linear() *= optical_to_body();
  }
  if (options.hand_held) {
    robot.name = "simulated-hand-held";
    robot.has_lidar = robot.has_odometry = robot.planar = false;
    robot.T_base_camera = SE3::Identity();
    robot.T_base_camera.linear() = optical_to_body();
  }
  return robot;
}

CameraModel camera_for(const std::optional<Route>& route, const SimulationOptions& options) {
  const double route_hz = route && route->camera ? route->camera->rate_hz : 30.0;
  CameraModel camera = simulated_camera(options.camera_hz.value_or(route_hz));
  if (route && route->camera) {
    const RouteCamera& c = *route->camera;
    camera.width_px = c.width_px;
    camera.height_px = c.height_px;
    camera.fx_px = c.fx_px;
    camera.fy_px = c.fy_px;
    camera.cx_px = c.cx_px;
    camera.cy_px = c.cy_px;
  }
  return camera;
}

std::vector<Eigen::Vector2d> way_points_for(const World& world, const std::optional<Route>& route,
                                            const SimulationOptions& options, double seconds) {
  if (!route && world.route_m.size() < 2)
    throw std::invalid_argument(
        "the world has no route of its own: give a route file (config/routes)");
  if (!options.random_route) return route ? route->way_points_m : world.route_m;
  RandomRouteOptions random;
  random.limits = route ? route->limits : world.limits;
  random.seconds = seconds;
  random.start_m = route ? route->way_points_m.front() : world.route_m.front();
  return random_route(world, random, options.seed);
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
  CameraModel camera;                   // 640x480, c = (319.5, 239.5), depth noise of the Astra
  camera.fx_px = camera.fy_px = 572.4;  // data sheet: 58.4 x 45.5 degrees
  camera.depth_min_m = 0.6;
  camera.depth_max_m = 8.0;
  camera.rate_hz = rate_hz;
  return camera;
}

const char* name_of(Channel channel) {
  constexpr const char* kNames[] = {"ROBOT_MODEL", "CAMERA_MODEL", "GROUND_TRUTH",
                                    "ODOMETRY",    "LIDAR",        "CAMERA"};
  return kNames[static_cast<std::size_t>(channel)];
}

struct Simulation::Impl {
  Impl(const World& world, const std::optional<Route>& route, const SimulationOptions& options_in,
       std::int64_t epoch_us_in)
      : options(options_in),
        epoch_us(epoch_us_in),
        seconds(
            options.seconds.value_or(route && route->seconds ? *route->seconds : kDefaultSeconds)),
        scene(world.boxes, world.meshes),
        on_paper(robot_for(route, options)),
        robot(on_paper),
        camera(camera_for(route, options)),
        way_points_m(way_points_for(world, route, options, seconds)),
        drive(way_points_m, route ? route->limits : world.limits, seconds + 1.0),
        odometry(wheel_odometry(drive, options.noise.wheels, options.seed, true)),
        sway(HandHeld{}, options.seed),
        renderer(scene, world.lighting, camera),
        noisy(camera, options.noise.camera, options.seed),
        exposure(options.noise.camera, 1.0 / camera.rate_hz) {
    robot.T_base_lidar = options.T_base_lidar.value_or(on_paper.T_base_lidar);
    robot.T_base_camera = options.T_base_camera.value_or(on_paper.T_base_camera);
    make_schedule();
    // Automatic exposure must not wait for frames that never come.
    at_rate(camera.rate_hz, seconds, [&](std::int64_t i, double t) {
      if (silent(Sensor::kCamera, t)) exposure.tell(i, std::nullopt);
    });
  }

  SE3 T_world_base(double time_s) const {
    const SE3 T_world_path = to_se3(drive.T_world_base(time_s));
    return options.hand_held ? T_world_path * sway.T_path_base(time_s) : T_world_path;
  }

  // Stamp minus truth of message `index`.
  std::int64_t jitter_us(std::uint64_t stream, std::int64_t index, double sigma_s,
                         double period_s) const {
    if (!options.noise.stamps.with_jitter) return 0;
    Random random(options.seed, stream, static_cast<std::uint64_t>(index));
    return us(
        std::clamp(sigma_s * random.gaussian(), -kMostJitter * period_s, kMostJitter * period_s));
  }

  bool silent(Sensor sensor, double time_s) const {
    return std::any_of(options.silent.begin(), options.silent.end(), [&](const Silence& s) {
      return s.sensor == sensor && s.span.holds(time_s);
    });
  }
  bool covered(double time_s) const {
    return std::any_of(options.covered.begin(), options.covered.end(),
                       [&](const TimeSpan& span) { return span.holds(time_s); });
  }

  // True times of a channel's messages: 0, 1 / rate_hz ... last_s.
  template <class Add>
  static void at_rate(double rate_hz, double last_s, const Add& add) {
    for (std::int64_t i = 0; static_cast<double>(i) / rate_hz <= last_s; ++i)
      add(i, static_cast<double>(i) / rate_hz);
  }
  void add(Channel channel, std::int64_t index, double time_s, std::int64_t jitter_us = 0,
           double ready_after_s = 0.0) {
    const std::int64_t utime_us =
        std::max(epoch_us, epoch_us + us(time_s) + jitter_us);  // nothing before the models
    due.push_back({utime_us, epoch_us + us(time_s + ready_after_s), channel, index});
  }

  void make_schedule() {
    const StampNoise& stamps = options.noise.stamps;
    due.clear();
    at_rate(kModelHz, seconds, [&](std::int64_t i, double t) {
      add(Channel::kRobotModel, i, t);
      add(Channel::kCameraModel, i, t);
    });
    at_rate(kOdometryHz, robot.has_odometry ? seconds : -1.0, [&](std::int64_t i, double t) {
      if (!silent(Sensor::kOdometry, t)) add(Channel::kOdometry, i, t);
    });
    const double turn_s = 1.0 / options.lidar_hz;  // whole sweeps only
    at_rate(options.lidar_hz, robot.has_lidar ? seconds - turn_s : -1.0,
            [&](std::int64_t i, double t) {
              if (!silent(Sensor::kLidar, t))
                add(Channel::kLidar, i, t,
                    jitter_us(kLidarStampStream, i, stamps.lidar_jitter_s, turn_s), turn_s);
            });
    at_rate(camera.rate_hz, seconds, [&](std::int64_t i, double t) {
      const std::int64_t j =
          jitter_us(kCameraStampStream, i, stamps.camera_jitter_s, 1.0 / camera.rate_hz);
      add(Channel::kGroundTruth, i, t, j);
      if (!silent(Sensor::kCamera, t))
        add(Channel::kCamera, i, t, j + us(options.camera_stamps_late_s));
    });
    std::sort(due.begin(), due.end(), [](const Due& a, const Due& b) {
      return std::tuple(a.utime_us, a.channel, a.index) <
             std::tuple(b.utime_us, b.channel, b.index);
    });
  }

  Bytes camera_frame(const Due& at) {
    const double time_s = static_cast<double>(at.index) / camera.rate_hz;
    const SE3 T_world_camera = T_world_base(time_s) * robot.T_base_camera;
    const double before_s = std::max(0.0, time_s - kTwistStepS), after_s = time_s + kTwistStepS;
    Shot shot;
    shot.index = at.index;
    shot.utime_us = at.utime_us;
    shot.twist = twist_between(T_world_base(before_s) * robot.T_base_camera,
                               T_world_base(after_s) * robot.T_base_camera, after_s - before_s);
    RgbdFrame frame;
    if (covered(time_s)) {
      exposure.tell(at.index, 0.0);
      shot.exposure = exposure.factor(at.index);
      frame = noisy.dark(shot);
    } else {
      const RenderedFrame ideal = renderer.render(T_world_camera);
      exposure.tell(at.index, mean_grey(ideal));
      shot.exposure = exposure.factor(at.index);
      frame = noisy.expose(ideal, shot);
    }
    bot_core::images_t message = to_message(frame);
    const CameraNoise& n = options.noise.camera;
    message.images[1].utime =  // the depth image's own stamp
        at.utime_us + (n.with_depth_delay ? us(n.depth_delay_s) : 0) +
        jitter_us(kDepthStampStream, at.index, options.noise.stamps.depth_jitter_s,
                  1.0 / camera.rate_hz);
    return encode(message);
  }

  SimulationOptions options;
  std::int64_t epoch_us;
  double seconds;
  Scene scene;
  RobotModel on_paper;
  RobotModel robot;  // as it is
  CameraModel camera;
  std::vector<Eigen::Vector2d> way_points_m;
  Drive drive;
  std::vector<SE2> odometry;
  HandHeldSway sway;
  CameraRenderer renderer;
  NoisyCamera noisy;
  AutoExposure exposure;
  std::vector<Due> due;
};

Simulation::Simulation(const World& world, const std::optional<Route>& route,
                       const SimulationOptions& options, std::int64_t epoch_us)
    : impl_(std::make_unique<Impl>(world, route, options, epoch_us)) {}
Simulation::~Simulation() = default;

void Simulation::start_at(std::int64_t epoch_us) {
  impl_->epoch_us = epoch_us;
  impl_->make_schedule();
}
void Simulation::practise() const {
  for (int i = 0; i < kPractiseFrames; ++i)
    impl_->renderer.render(impl_->T_world_base(impl_->seconds * i / kPractiseFrames) *
                           impl_->robot.T_base_camera);
}
const std::vector<Due>& Simulation::schedule() const { return impl_->due; }
void Simulation::skip_frame(const Due& due) const { impl_->exposure.tell(due.index, std::nullopt); }
void Simulation::cancel() const { impl_->exposure.cancel(); }
SE3 Simulation::T_world_base(double time_s) const { return impl_->T_world_base(time_s); }
const RobotModel& Simulation::robot() const { return impl_->robot; }
const CameraModel& Simulation::camera() const { return impl_->camera; }
double Simulation::seconds() const { return impl_->seconds; }
double Simulation::lap_s() const { return impl_->drive.lap_s(); }
const std::vector<Eigen::Vector2d>& Simulation::way_points_m() const { return impl_->way_points_m; }

Bytes Simulation::message(const Due& due) const {
  Impl& my = *impl_;
  const auto with_seq = [&](auto message) {
    message.seq = due.index + 1;
    return encode(message);
  };
  const double stamp_s = 1e-6 * static_cast<double>(due.utime_us - my.epoch_us);
  switch (due.channel) {
    case Channel::kRobotModel:
      return with_seq(to_message(my.on_paper, due.utime_us));
    case Channel::kCameraModel:
      return with_seq(to_message(my.camera, due.utime_us));
    case Channel::kGroundTruth:
      return encode(to_pose_message(my.T_world_base(stamp_s), due.utime_us));
    case Channel::kOdometry: {
      const auto step = static_cast<std::size_t>(std::llround(stamp_s / Drive::kStepS));
      return encode(to_pose_message(to_se3(my.odometry[step]), due.utime_us));
    }
    case Channel::kLidar: {
      const double begin_s = static_cast<double>(due.index) / my.options.lidar_hz;
      const auto pose_after = [&](double s) { return my.drive.T_world_base(begin_s + s); };
      return encode(to_message(sweep(my.scene, my.robot, my.options.noise.lidar, pose_after,
                                     due.utime_us, my.options.seed, due.index, true)));
    }
    case Channel::kCamera:
      return my.camera_frame(due);
  }
  return {};
}

}  // namespace fusion_slam
