// The same Bus over LCM's file provider: a log is read, and written, by the code that talks UDP.
#include <filesystem>

#include <gtest/gtest.h>

#include "bot_core/pose_t.hpp"
#include "fusion_slam/command_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/eventlog/writer.hpp"

namespace fusion_slam {
namespace {

std::filesystem::path file(const std::string& name) {
  const auto path = std::filesystem::path(testing::TempDir()) / ("file_bus_" + name + ".lcm");
  std::filesystem::remove(path);
  return path;
}

TEST(FileBus, ReadsALogToItsEndInOrderAndLosesNothing) {
  constexpr int kMessages = 6000;  // more than any queue holds
  const auto path = file("read");
  LogWriter writer(path);
  for (int i = 1; i <= kMessages; ++i) {
    bot_core::pose_t pose{};
    pose.utime = 1000 * i;
    writer.write(1000 * i, "ODOMETRY", bus_detail::encode(pose));
    command_t command{};
    command.utime = 1000 * i;
    command.seq = i;
    if (i % 100 == 0) writer.write(1000 * i, "COMMAND", bus_detail::encode(command));
  }
  writer.close();
  BusOptions options;
  options.url = "file://" + path.string() + "?speed=0";
  options.process = "reader";
  Bus bus(options);
  std::vector<std::int64_t> utimes;
  int commands = 0;
  bus.subscribe<bot_core::pose_t>("ODOMETRY", Policy::kKeepAll,
                                  [&](const bot_core::pose_t& m) { utimes.push_back(m.utime); });
  bus.subscribe<command_t>("COMMAND", Policy::kKeepAll, [&](const command_t&) { ++commands; });
  bus.run();  // ends with the log
  ASSERT_EQ(utimes.size(), static_cast<std::size_t>(kMessages));
  for (int i = 0; i < kMessages; ++i)
    EXPECT_EQ(utimes[static_cast<std::size_t>(i)], 1000 * (i + 1));
  EXPECT_EQ(commands, kMessages / 100);
}

TEST(FileBus, WritesALogThatOurReaderReads) {
  const auto path = file("write");
  {
    BusOptions options;
    options.url = "file://" + path.string() + "?mode=w";
    options.process = "writer";
    Bus bus(options);
    for (int i = 1; i <= 20; ++i) {
      command_t command{};
      command.utime = i;
      command.verb = "go";
      bus.publish("COMMAND", command);
    }
  }
  LogReader reader(path);
  LogEvent event;
  int commands = 0;
  while (reader.next(&event)) {
    if (event.channel != "COMMAND") continue;
    command_t command{};
    ASSERT_GT(command.decode(event.data.data(), 0, static_cast<int>(event.data.size())), 0);
    EXPECT_EQ(command.seq, ++commands);
  }
  EXPECT_FALSE(reader.damage());
  EXPECT_EQ(commands, 20);
}

}  // namespace
}  // namespace fusion_slam
