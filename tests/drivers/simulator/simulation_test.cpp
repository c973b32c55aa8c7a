#include "drivers/simulator/simulation.hpp"

#include <map>
#include <mutex>
#include <set>

#include <gtest/gtest.h>

#include "drivers/simulator/arguments.hpp"
#include "drivers/simulator/live_run.hpp"
#include "drivers/simulator/random_route.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/config/yaml_map.hpp"
#include "libs/messages/convert.hpp"

namespace fusion_slam {
namespace {

// A room of 4 x 6 m with a pillar in its middle.
constexpr const char* kRoom = R"(
route: [[0, 0.6], [2, 0.6], [2, 1.5]]
lamps: [[1, 1, 2]]
walls:
  - {from: [-1, -0.5], to: [5, -0.5]}
  - {from: [5, -0.5], to: [5, 3.5]}
  - {from: [5, 3.5], to: [-1, 3.5]}
  - {from: [-1, 3.5], to: [-1, -0.5]}
things:
  - {kind: box, at: [2, 1.5, -0.1], size_m: [6.5, 4.5, 0.1], texture: carpet}
  - {kind: box, at: [3.4, 1.6], size_m: [0.4, 0.4, 0.45]}
)";
World room() { return world_from_text(kRoom, "room"); }

// The same way with a small camera: quick.
Route small_route() {
  return route_from_text(
      "route: [[0, 0.6], [2, 0.6], [2, 1.5]]\n"
      "camera: {fx: 143, width: 160, height: 120}\n",
      "small");
}

SimulationOptions short_run() {
  SimulationOptions options;
  options.seconds = 1.0;
  options.camera_hz = 5.0;
  return options;
}

std::map<Channel, std::vector<Due>> by_channel(const Simulation& simulation) {
  std::map<Channel, std::vector<Due>> all;
  for (const Due& due : simulation.schedule()) all[due.channel].push_back(due);
  return all;
}

template <class Message>
Message decoded(const Bytes& bytes) {
  Message message;
  EXPECT_GE(message.decode(bytes.data(), 0, static_cast<int>(bytes.size())), 0);
  return message;
}

TEST(Simulation, StampsJitterAndDepthHasItsOwn) {
  SimulationOptions options = short_run();
  const Simulation jittery(room(), small_route(), options);
  set_effect("all", false, &options.noise);
  const Simulation exact(room(), small_route(), options);
  auto a = by_channel(jittery), b = by_channel(exact);
  ASSERT_EQ(a[Channel::kCamera].size(), b[Channel::kCamera].size());
  int different = 0;
  for (std::size_t i = 0; i < a[Channel::kCamera].size(); ++i) {
    const auto off = a[Channel::kCamera][i].utime_us - b[Channel::kCamera][i].utime_us;
    EXPECT_LT(std::abs(off), 6000);
    different += off != 0 ? 1 : 0;
    EXPECT_EQ(a[Channel::kGroundTruth][i].utime_us, a[Channel::kCamera][i].utime_us);
    EXPECT_EQ(b[Channel::kCamera][i].utime_us, kEpochUs + 200'000 * static_cast<std::int64_t>(i));
  }
  EXPECT_GT(different, 2);
  const auto noisy = decoded<bot_core::images_t>(jittery.message(a[Channel::kCamera][0]));
  EXPECT_EQ(noisy.images[0].utime, noisy.utime);
  EXPECT_NEAR(static_cast<double>(noisy.images[1].utime - noisy.utime), 4000.0, 5000.0);
  const auto clean = decoded<bot_core::images_t>(exact.message(b[Channel::kCamera][0]));
  EXPECT_EQ(clean.images[1].utime, clean.utime);
}

TEST(Simulation, CoveredLensAndSilentSensors) {
  SimulationOptions options = short_run();
  options.covered.push_back(time_span_from("0.3,0.5"));
  options.silent.push_back(silence_from("lidar,0.2,0.6"));
  options.silent.push_back(silence_from("camera,0.7,0.9"));
  options.silent.push_back(silence_from("odometry,0,0.5"));
  const Simulation simulation(room(), small_route(), options);
  auto all = by_channel(simulation);
  ASSERT_EQ(all[Channel::kCamera].size(), 5U);  // 0, 0.2, 0.4, 0.6, 1.0 s
  EXPECT_EQ(all[Channel::kCamera][4].index, 5);
  EXPECT_EQ(all[Channel::kOdometry].size(), 26U);
  EXPECT_EQ(all[Channel::kLidar].size(), 4U);  // 0, 1/7 and 5/7, 6/7 s
  for (std::size_t i = 0; i < 5; ++i) {
    std::string why;
    const auto frame = from_message(
        decoded<bot_core::images_t>(simulation.message(all[Channel::kCamera][i])), &why);
    ASSERT_TRUE(frame) << why;
    if (i == 2) {
      EXPECT_LT(cv::mean(frame->colour_bgr)[0], 8.0);
    } else {
      EXPECT_GT(cv::mean(frame->colour_bgr)[0], 20.0);
    }
    EXPECT_EQ(cv::countNonZero(frame->depth_mm) == 0, i == 2);
  }
}

TEST(Simulation, HandHeldIsACameraAloneWhoseBaseIsTheCamera) {
  SimulationOptions options = short_run();
  options.hand_held = true;
  const Simulation simulation(room(), {}, options);
  EXPECT_FALSE(simulation.robot().planar);
  EXPECT_FALSE(simulation.robot().has_lidar);
  EXPECT_EQ(simulation.robot().T_base_camera.translation().norm(), 0.0);
  auto all = by_channel(simulation);
  EXPECT_EQ(all.count(Channel::kLidar) + all.count(Channel::kOdometry), 0U);
  const Due& due = all[Channel::kGroundTruth][3];
  const auto truth = from_message(decoded<bot_core::pose_t>(simulation.message(due)));
  ASSERT_TRUE(truth);
  EXPECT_TRUE(truth->isApprox(
      simulation.T_world_base(1e-6 * static_cast<double>(due.utime_us - kEpochUs)), 1e-9));
  EXPECT_GT(truth->translation().z(), 1.1);
  EXPECT_GT(std::fabs((truth->linear() * Eigen::Vector3d::UnitX()).z()), 0.01);  // not level
}

TEST(Simulation, RouteFileSetsCameraAndNoise) {
  const Route route = route_from_text(
      "route: [[0, 0.6], [1, 0.6]]\nseconds: 2\n"
      "limits: {speed_m_s: 0.3, turn_rad_s: 1.571, turn_accel_rad_s2: 8}\n"
      "camera: {fx: 300, width: 320, height: 240, rate_hz: 4, x_m: 0.2, z_m: 0.5, pitch_deg: 10}\n",
      "route");
  SimulationOptions options;
  const Simulation simulation(room(), route, options);
  EXPECT_EQ(simulation.seconds(), 2.0);
  EXPECT_EQ(simulation.camera().width_px, 320);
  EXPECT_EQ(simulation.camera().fy_px, 300.0);
  EXPECT_EQ(simulation.camera().rate_hz, 4.0);
  const SE3& T = simulation.robot().T_base_camera;
  EXPECT_NEAR(T.translation().x(), 0.2, 1e-12);
  EXPECT_NEAR((T.linear() * Eigen::Vector3d::UnitZ()).z(), -std::sin(10 * M_PI / 180), 1e-9);
}

TEST(Arguments, TextsOfTimesAreChecked) {
  EXPECT_EQ(time_span_from("1.5,2").to_s, 2.0);
  for (const char* bad : {"", "1", "2,1", "a,2", "1,2,3", "-1,2", "1,nan"})
    EXPECT_THROW(time_span_from(bad), std::invalid_argument) << bad;
  EXPECT_EQ(silence_from("odometry,1,2").sensor, Sensor::kOdometry);
  EXPECT_THROW(silence_from("radar,1,2"), std::invalid_argument);
  EXPECT_THROW(silence_from("lidar,1"), std::invalid_argument);
}

TEST(RandomRoute, KeepsTheRobotsRadiusFreeAndFollowsFromTheSeed) {
  RandomRouteOptions options;
  options.start_m = {0.0, 0.6};
  options.seconds = 25.0;
  const auto points = random_route(room(), options, 7);
  EXPECT_EQ(points, random_route(room(), options, 7));
  EXPECT_NE(points, random_route(room(), options, 8));
  EXPECT_EQ(points.front(), options.start_m);
  const Drive drive(points, options.limits, options.seconds);
  double farthest = 0.0;
  for (double t = 0.0; t < options.seconds; t += 0.1) {
    const SE2 at = drive.T_world_base(t);
    // Against the room itself, not the map: walls are 0.12 m thick.
    EXPECT_GT(at.x, -1.0 + 0.06 + 0.2);
    EXPECT_LT(at.x, 5.0 - 0.06 - 0.2);
    EXPECT_GT(at.y, -0.5 + 0.06 + 0.2);
    EXPECT_LT(at.y, 3.5 - 0.06 - 0.2);
    const double dx = std::max(0.0, std::fabs(at.x - 3.4) - 0.2);
    const double dy = std::max(0.0, std::fabs(at.y - 1.6) - 0.2);
    EXPECT_GT(std::hypot(dx, dy), 0.2);
    farthest = std::max(farthest, std::hypot(at.x, at.y - 0.6));
  }
  EXPECT_GT(farthest, 1.5);
  options.robot_radius_m = 1.9;
  EXPECT_THROW(random_route(room(), options, 7), std::invalid_argument);
}

// Drops on a slow machine are allowed here: only what goes out is looked at, and the counts.
TEST(LiveRun, PublishesWhatTheLogWouldHold) {
  SimulationOptions options = short_run();
  set_effect("exposure", false, &options.noise);  // it looks at the frames before, if any
  Simulation simulation(room(), small_route(), options), same(room(), small_route(), options);
  std::mutex mutex;
  std::map<std::string, std::vector<Bytes>> sent;
  LiveRun live(simulation, 1, [&](const std::string& channel, const Bytes& bytes) {
    const std::lock_guard<std::mutex> lock(mutex);
    sent[channel].push_back(bytes);
  });
  live.run();
  same.start_at(by_channel(simulation)[Channel::kRobotModel][0].utime_us);
  auto expected = by_channel(same);
  for (const auto& [channel, dues] : expected) {
    std::set<Bytes> whole;
    for (const Due& due : dues) whole.insert(same.message(due));
    for (const Bytes& bytes : sent[name_of(channel)])
      EXPECT_EQ(whole.count(bytes), 1U) << name_of(channel);
    if (channel != Channel::kCamera) {
      EXPECT_EQ(sent[name_of(channel)].size(), dues.size());
    }
  }
  const LiveRun::Progress p = live.progress();
  EXPECT_EQ(p.frames_published, static_cast<std::int64_t>(sent["CAMERA"].size()));
  EXPECT_EQ(p.frames_published + p.frames_dropped, 6);
}

}  // namespace
}  // namespace fusion_slam
