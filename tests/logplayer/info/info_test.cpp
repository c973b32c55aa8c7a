#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "bot_core/pose_t.hpp"
#include "libs/eventlog/writer.hpp"
#include "logplayer/info/report.hpp"
#include "tests/libs/eventlog/files.hpp"
#include "tests/libs/netcheck/private_network.hpp"
#include "tests/libs/schema/encode.hpp"
#include "tests/support/recordings.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

constexpr std::int64_t kStart_us = 1'700'000'000'250'000;

void write_log(const std::filesystem::path& path) {
  LogWriter writer(path);
  bot_core::pose_t pose{};
  for (const std::int64_t ms : {0, 100, 200, 700, 800}) {
    pose.utime = kStart_us + 1000 * ms;
    writer.write(pose.utime, "ODOMETRY", encoded(pose));
  }
  writer.write(kStart_us + 900'000, "FOREIGN", to_bytes("123456789"));
  writer.close();
}

LogSummary summary_of(const std::filesystem::path& path) {
  LogReader reader(path);
  return summarise(reader);
}

ShellResult info(const std::string& arguments) {
  return run_shell(std::string(FS_BINARY_DIR) + "/bin/info " + arguments);
}

TEST(Info, prints_a_table) {
  const TemporaryFolder folder;
  write_log(folder / "a.lcm");
  EXPECT_EQ(text_report("a.lcm", summary_of(folder / "a.lcm")),
            "a.lcm\n"
            "size      944 bytes, 6 events, 2 channels\n"
            "start     2023-11-14 22:13:20.250000 UTC\n"
            "duration  0.900 s\n"
            "\n"
            "channel   type                        count    Hz  min B  mean B  max B  largest gap "
            "s   at s      first utime s "
            "      last utime s\n"
            "FOREIGN   unknown 0x3132333435363738      1  0.00      9       9      9          "
            "0.000  0.900                  - "
            "                 -\n"
            "ODOMETRY  bot_core.pose_t                 5  5.00    144     144    144          "
            "0.500  0.200  1700000000.250000 "
            " 1700000001.050000\n");
}

TEST(Info, prints_json) {
  const TemporaryFolder folder;
  write_log(folder / "a.lcm");
  const auto report = nlohmann::json::parse(json_report("a.lcm", summary_of(folder / "a.lcm")));
  EXPECT_EQ(report["events"], 6);
  EXPECT_EQ(report["start_us"], kStart_us);
  EXPECT_NEAR(report["duration_s"], 0.9, 1e-6);
  const auto& odometry = report["channels"]["ODOMETRY"];
  EXPECT_EQ(odometry["types"]["bot_core.pose_t"], 5);
  EXPECT_DOUBLE_EQ(odometry["rate_hz"], 5.0);
  EXPECT_EQ(odometry["bytes"]["max"], 144);
  EXPECT_EQ(odometry["last_utime_us"], kStart_us + 800'000);
  EXPECT_TRUE(report["channels"]["FOREIGN"]["first_utime_us"].is_null());
  EXPECT_TRUE(report["damages"].empty());
}

TEST(Info, tells_of_damage_and_strange_names) {
  const TemporaryFolder folder;
  write_file(folder / "d.lcm",
             event_bytes(0, -1, "\xFF\xFE", "x") + event_bytes(1, 5, "B", "y") + "cut");
  const LogSummary summary = summary_of(folder / "d.lcm");
  EXPECT_THAT(text_report("d.lcm", summary), HasSubstr("damaged in 1 places"));
  EXPECT_EQ(nlohmann::json::parse(json_report("d.lcm", summary))["damages"].size(), 1U);
}

TEST(Info, the_program_reports_success_failure_and_wrong_usage) {
  const TemporaryFolder folder;
  write_log(folder / "a.lcm");
  write_file(folder / "empty.lcm", "");
  EXPECT_EQ(info((folder / "a.lcm").string()).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(info("--json " + (folder / "a.lcm").string()).output)["events"],
            6);
  EXPECT_EQ(info("--help").exit_code, 0);
  EXPECT_EQ(info("").exit_code, 2);
  EXPECT_EQ(info("--no-such-option x").exit_code, 2);
  const ShellResult empty = info((folder / "empty.lcm").string());
  EXPECT_EQ(empty.exit_code, 1);
  EXPECT_THAT(empty.output, HasSubstr("the file is empty"));
}

TEST(Info, reads_a_real_log) {
  FS_RECORDING(path, "lidar/lcm-maebot-empty/empty_environment.log");
  const LogSummary summary = summary_of(path);
  EXPECT_EQ(summary.channels.at("MAEBOT_LASER_SCAN").n_messages, 403);
  EXPECT_NEAR(summary.channels.at("MAEBOT_LASER_SCAN").rate_hz(), 6.84, 0.005);
  EXPECT_THAT(text_report("x", summary), HasSubstr("duration  58.818 s"));
}

}  // namespace
}  // namespace fusion_slam
