#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bot_core/pose_t.hpp"
#include "fusion_slam/command_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "fusion_slam/status_t.hpp"
#include "fusion_slam/tile_t.hpp"
#include "libs/eventlog/writer.hpp"
#include "logplayer/verify/verifier.hpp"
#include "tests/libs/eventlog/files.hpp"
#include "tests/libs/netcheck/private_network.hpp"
#include "tests/libs/schema/encode.hpp"
#include "tests/support/recordings.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

std::vector<std::uint8_t> pose(std::int64_t utime) {
  bot_core::pose_t message{};
  message.utime = utime;
  return encoded(message);
}

template <class Message>
std::vector<std::uint8_t> numbered(std::int64_t seq, std::int64_t utime, Message message = {}) {
  message.seq = seq;
  message.utime = utime;
  return encoded(message);
}

std::vector<std::uint8_t> status(const std::string& process, std::int64_t seq) {
  status_t message{};
  message.process = process;
  return numbered(seq, 1000 * seq, message);
}

VerifyReport verified(const std::filesystem::path& path) {
  LogReader reader(path);
  return verify(reader);
}

ShellResult run(const std::string& arguments) {
  return run_shell(std::string(FS_BINARY_DIR) + "/bin/verify " + arguments);
}

TEST(Verify, finds_nothing_in_a_sound_log) {
  const TemporaryFolder folder;
  LogWriter writer(folder / "a.lcm");
  for (int i = 1; i < 10; ++i) {
    writer.write(1'000'000 * i, "ODOMETRY", pose(1000 * i));
    writer.write(1'000'000 * i - 50'000, "LIDAR_POSE", numbered<pose_estimate_t>(i, 1000 * i));
    writer.write(1'000'000 * i, "STATUS", status("fuser", i));
    writer.write(1'000'000 * i, "STATUS", status("pose_graph", 100 + i));
    writer.write(1'000'000 * i, "SUBMAP", numbered<tile_t>(i, 50 - i));
    writer.write(1'000'000 * i, "COMMAND",
                 numbered<command_t>(7 * i, 100 - i));  // anybody may send one
    writer.write(1'000'000 * i, "FOREIGN", to_bytes("12345678 foreign"));
  }
  writer.close();
  const VerifyReport report = verified(folder / "a.lcm");
  EXPECT_EQ(text_report("a.lcm", report, 50),
            "note: FOREIGN: 9 messages of a type that this program doesn't have (unknown "
            "0x3132333435363738); not checked\n"
            "note: 9 events carry a log time up to 0.1 s before that of the event in front of "
            "them, as lcm-logger does it\n"
            "a.lcm: 63 events, nothing wrong\n");
  const ShellResult result = run((folder / "a.lcm").string());
  EXPECT_EQ(result.exit_code, 0) << result.output;
}

TEST(Verify, finds_each_kind_of_fault_with_its_byte) {
  const TemporaryFolder folder;
  LogWriter writer(folder / "b.lcm");
  writer.write(5'000'000, "ODOMETRY", pose(2'000'000));  // byte 0, 28 + 8 + 144
  writer.write(4'000'000, "ODOMETRY", pose(1'000'000));  // byte 180
  writer.write(6'000'000, "T", numbered<tile_t>(1, 1));  // byte 360
  const std::int64_t hole = writer.size_bytes();
  writer.write(6'000'000, "T", numbered<tile_t>(4, 1));
  std::vector<std::uint8_t> bad = numbered<tile_t>(5, 1);
  bad[bad.size() - 4] = 0x7F;
  const std::int64_t undecodable = writer.size_bytes();
  writer.write(6'000'000, "T", bad);
  const std::int64_t damage = writer.size_bytes();
  writer.close();
  write_file(folder / "b.lcm",
             read_file(folder / "b.lcm") + event_bytes(9, 9, "T", "xyz").substr(0, 20));

  const std::string file = (folder / "b.lcm").string();
  const auto at = [&](std::int64_t byte) { return file + ": byte " + std::to_string(byte) + ": "; };
  EXPECT_EQ(text_report(file, verified(folder / "b.lcm"), 50),
            at(180) + "ODOMETRY: log time goes back by 1.000000 s, from 5.000000 to 4.000000\n" +
                at(180) +
                "ODOMETRY: measurement time goes back by 1.000000 s, from 2.000000 to 1.000000\n" +
                at(hole) +
                "T: seq 2 to 3 are missing (2 messages); the message before stands at byte 360\n" +
                at(undecodable) +
                "T: cannot be decoded: fusion_slam.tile_t.data: length 2130706432 needs more than "
                "the 0 bytes left\n" +
                at(damage) +
                "the event needs 28 bytes but the file ends after 20: the recording was cut; every "
                "event before this one is whole\n" +
                file +
                ": 5 events, 1 places that are no events, 1 holes in sequence numbers, 1 steps "
                "back in log time, "
                "1 steps back in measurement time, 1 undecodable messages\n");

  const ShellResult result = run(file + " --max-lines 2");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("... and 3 more (--max-lines 5 shows all)"));
}

TEST(Verify, the_program_explains_failure_and_wrong_usage) {
  const TemporaryFolder folder;
  write_file(folder / "text.lcm", "no log");
  EXPECT_EQ(run("--help").exit_code, 0);
  EXPECT_EQ(run("").exit_code, 2);
  EXPECT_EQ(run("--max-lines x y").exit_code, 2);
  const ShellResult foreign = run((folder / "text.lcm").string());
  EXPECT_EQ(foreign.exit_code, 1);
  EXPECT_THAT(foreign.output, HasSubstr("is not an LCM event log"));
}

// Recorded by lcm-logger: types of another lab, and its own small steps back in log time.
TEST(Verify, finds_nothing_wrong_in_a_real_log) {
  FS_RECORDING(path, "lidar/lcm-maebot-empty/empty_environment.log");
  const VerifyReport report = verified(path);
  EXPECT_TRUE(report.findings.empty());
  EXPECT_EQ(report.n_events, 6486);
  EXPECT_EQ(report.foreign.size(), 6U);
  EXPECT_EQ(report.n_jitter, 9);
}

}  // namespace
}  // namespace fusion_slam
