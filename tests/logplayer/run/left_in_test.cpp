// `run --without`: a log as a robot with fewer sensors would have written it.
#include <gtest/gtest.h>

#include "fusion_slam/robot_model_t.hpp"
#include "logplayer/run/playback.hpp"

namespace fusion_slam {
namespace {

LogEvent event(const std::string& channel, std::vector<std::uint8_t> data = {1, 2, 3}) {
  LogEvent event;
  event.channel = channel;
  event.data = std::move(data);
  return event;
}

bool left(const std::set<std::string>& without, const std::string& channel) {
  LogEvent e = event(channel);
  return left_in(without, &e);
}

TEST(LeftIn, EachInputTakesItsChannelsWithIt) {
  for (const char* channel : {"CAMERA", "CAMERA_MODEL", "LIDAR", "ODOMETRY", "GROUND_TRUTH"})
    EXPECT_TRUE(left({}, channel)) << channel;
  EXPECT_FALSE(left({"camera"}, "CAMERA"));
  EXPECT_FALSE(left({"camera"}, "CAMERA_MODEL"));
  EXPECT_TRUE(left({"camera"}, "LIDAR"));
  EXPECT_FALSE(left({"lidar", "odometry"}, "LIDAR"));
  EXPECT_FALSE(left({"lidar", "odometry"}, "ODOMETRY"));
  EXPECT_TRUE(left({"lidar", "odometry"}, "CAMERA"));
  EXPECT_TRUE(left({"camera", "lidar", "odometry"}, "GROUND_TRUTH"));
}

TEST(LeftIn, TheRobotIsToldWhatItLacks) {
  robot_model_t robot{};
  robot.name = "tin";
  robot.has_camera = robot.has_lidar = robot.has_odometry = 1;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(robot.getEncodedSize()));
  robot.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  LogEvent e = event("ROBOT_MODEL", bytes);
  EXPECT_TRUE(left_in({"lidar", "odometry"}, &e));
  robot_model_t told{};
  ASSERT_GT(told.decode(e.data.data(), 0, static_cast<int>(e.data.size())), 0);
  EXPECT_EQ(told.name, "tin");
  EXPECT_TRUE(told.has_camera);
  EXPECT_FALSE(told.has_lidar);
  EXPECT_FALSE(told.has_odometry);
  // What can't be decoded is left as it is: the replay counts it.
  LogEvent broken = event("ROBOT_MODEL");
  EXPECT_TRUE(left_in({"lidar"}, &broken));
  EXPECT_EQ(broken.data.size(), 3U);
}

}  // namespace
}  // namespace fusion_slam
