#include "drivers/simulator/recording.hpp"

#include <fstream>
#include <map>
#include <sstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "libs/camera_messages/images.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

constexpr const char* kWorld = R"(
route: [[0, 0], [2, 0], [2, 1]]
lamps: [[1, 0, 2]]
walls:
  - {from: [3, -2], to: [3, 2], height_m: 1.2, texture: brick}
  - {from: [-1, 2], to: [3, 2], height_m: 1.2}
things:
  - {kind: box, at: [1, 0, -0.1], size_m: [5, 5, 0.1], texture: carpet}
  - {kind: chair, at: [2.5, 0.8], yaw_deg: 30}
)";

class Recording : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        std::filesystem::temp_directory_path() / ("simulate_test_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  static Simulation simulation(std::uint64_t seed, bool noise = true) {
    SimulationOptions options;
    options.seed = seed;
    options.seconds = 2.0;
    options.camera_hz = 3.0;
    if (!noise) set_effect("all", false, &options.noise);
    return Simulation(world_from_text(kWorld, "world"), {}, options);
  }
  std::string bytes(std::uint64_t seed, int threads, bool noise = true) {
    write_recording(simulation(seed, noise), threads, file(), {});
    std::ifstream in(file(), std::ios::binary);
    std::ostringstream all;
    all << in.rdbuf();
    return all.str();
  }
  std::filesystem::path file() const { return folder_ / "log.lcm"; }
  std::filesystem::path folder_;
};

TEST_F(Recording, EqualSeedsGiveEqualBytes) {
  const std::string first = bytes(4, 1);
  EXPECT_TRUE(first == bytes(4, 1));
  EXPECT_TRUE(first == bytes(4, 3)) << "the number of threads shows";
  EXPECT_FALSE(first == bytes(5, 1));
}

TEST_F(Recording, HoldsEveryChannelInOrderOfTime) {
  bytes(1, 2, false);
  LogReader reader(file());
  LogEvent event;
  std::map<std::string, int> counts;
  std::int64_t last = kEpochUs;
  std::string why;
  while (reader.next(&event)) {
    EXPECT_GE(event.timestamp_us, last);
    last = event.timestamp_us;
    ++counts[event.channel];
    const auto n = static_cast<int>(event.data.size());
    if (event.channel == "CAMERA") {
      bot_core::images_t message;
      ASSERT_GE(message.decode(event.data.data(), 0, n), 0);
      EXPECT_EQ(message.utime, event.timestamp_us);
      const auto frame = from_message(message, &why);
      ASSERT_TRUE(frame) << why;
      EXPECT_GT(cv::countNonZero(frame->depth_mm), 50000);
    } else if (event.channel == "ROBOT_MODEL") {
      robot_model_t message;
      ASSERT_GE(message.decode(event.data.data(), 0, n), 0);
      EXPECT_EQ(message.seq, counts[event.channel]);
      EXPECT_TRUE(from_message(message, &why)) << why;
    } else if (event.channel == "LIDAR") {
      bot_core::planar_lidar_t message;
      ASSERT_GE(message.decode(event.data.data(), 0, n), 0);
      EXPECT_TRUE(from_message(message, &why)) << why;
    }
  }
  const std::map<std::string, int> expected = {{"CAMERA", 7},       {"CAMERA_MODEL", 3},
                                               {"GROUND_TRUTH", 7}, {"LIDAR", 14},
                                               {"ODOMETRY", 101},   {"ROBOT_MODEL", 3}};
  EXPECT_EQ(counts, expected);
}

TEST_F(Recording, SaysWhenItCannotWrite) {
  EXPECT_THROW(write_recording(simulation(1), 1, folder_ / "no" / "log.lcm", {}),
               std::runtime_error);
}

}  // namespace
}  // namespace fusion_slam
