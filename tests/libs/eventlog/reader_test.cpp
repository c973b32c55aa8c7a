#include "libs/eventlog/reader.hpp"

#include <map>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/libs/eventlog/files.hpp"
#include "tests/support/recordings.hpp"

namespace fusion_slam {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string open_error(const std::filesystem::path& path) {
  try {
    LogReader reader(path);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

// Two events, the first of 28 + 4 + 3 bytes.
std::string two_events() {
  return event_bytes(0, 1'000'000, "POSE", "abc") + event_bytes(1, -7, "TILE_2", "");
}

TEST(LogReader, reads_a_log_written_by_hand) {
  const TemporaryFolder folder;
  const std::string bytes(
      "\xED\xA1\xDA\x01"                  // sync
      "\x00\x00\x00\x00\x00\x00\x00\x00"  // event 0
      "\x00\x00\x00\x00\x00\x0F\x42\x40"  // 1 s
      "\x00\x00\x00\x04\x00\x00\x00\x03"  // 4 bytes of channel, 3 of data
      "POSEabc",
      35);
  EXPECT_EQ(bytes, event_bytes(0, 1'000'000, "POSE", "abc"));
  write_file(folder / "a.lcm", two_events());
  LogReader reader(folder / "a.lcm");
  EXPECT_EQ(reader.size_bytes(), 35 + 34);
  LogEvent event;
  ASSERT_TRUE(reader.next(&event));
  EXPECT_EQ(event.offset_bytes, 0);
  EXPECT_EQ(event.number, 0);
  EXPECT_EQ(event.timestamp_us, 1'000'000);
  EXPECT_EQ(event.channel, "POSE");
  EXPECT_EQ(event.data, to_bytes("abc"));
  ASSERT_TRUE(reader.next(&event));
  EXPECT_EQ(event.offset_bytes, 35);
  EXPECT_EQ(event.number, 1);
  EXPECT_EQ(event.timestamp_us, -7);
  EXPECT_EQ(event.channel, "TILE_2");
  EXPECT_TRUE(event.data.empty());
  EXPECT_FALSE(reader.next(&event));
  EXPECT_FALSE(reader.damage());
  reader.seek(35);
  ASSERT_TRUE(reader.next(&event));
  EXPECT_EQ(event.channel, "TILE_2");
}

TEST(LogReader, says_what_a_file_is_that_is_no_log) {
  const TemporaryFolder folder;
  EXPECT_THAT(open_error(folder / "none.lcm"),
              AllOf(HasSubstr("none.lcm"), HasSubstr("No such file")));
  EXPECT_THAT(open_error(folder / ""), HasSubstr("is not a file"));
  write_file(folder / "empty.lcm", "");
  EXPECT_THAT(open_error(folder / "empty.lcm"), HasSubstr("the file is empty (0 bytes)"));
  write_file(folder / "text.lcm", "hello");
  EXPECT_THAT(open_error(folder / "text.lcm"),
              AllOf(HasSubstr("not an LCM event log"), HasSubstr("import --help")));
  write_file(folder / "x.gz", "\x1f\x8b\x08 rest");
  EXPECT_THAT(open_error(folder / "x.gz"), HasSubstr("gunzip"));
  write_file(folder / "x.bag", "#ROSBAG V2.0\n");
  EXPECT_THAT(open_error(folder / "x.bag"), HasSubstr("ROS bag"));
  write_file(folder / "x.clf", "# comment\nFLASER 180 1.0 1.0\n");
  EXPECT_THAT(open_error(folder / "x.clf"), HasSubstr("import carmen"));
}

TEST(LogReader, a_cut_recording_is_read_to_its_last_whole_event) {
  const TemporaryFolder folder;
  const std::string bytes = two_events();
  for (std::size_t n = 36; n < bytes.size(); ++n) {
    write_file(folder / "cut.lcm", bytes.substr(0, n));
    LogReader reader(folder / "cut.lcm");
    LogEvent event;
    ASSERT_TRUE(reader.next(&event)) << n;
    EXPECT_FALSE(reader.next(&event)) << n;
    ASSERT_TRUE(reader.damage()) << n;
    EXPECT_EQ(reader.damage()->offset_bytes, 35) << n;
    EXPECT_TRUE(reader.damage()->at_end) << n;
    EXPECT_THAT(reader.damage()->message,
                AllOf(HasSubstr("cut.lcm: byte 35:"), HasSubstr("the recording was cut")))
        << n;
    EXPECT_FALSE(reader.resync()) << n;
  }
}

TEST(LogReader, names_a_damage_and_goes_on_behind_it) {
  const TemporaryFolder folder;
  const std::string head = event_bytes(0, 1, "A", "first");
  const std::string tail = event_bytes(2, 3, "C", "third");
  const auto damaged = [&](const std::string& middle, const std::string& expected) {
    write_file(folder / "d.lcm", head + middle + tail);
    LogReader reader(folder / "d.lcm");
    LogEvent event;
    while (reader.next(&event)) {
    }
    ASSERT_TRUE(reader.damage());
    EXPECT_THAT(reader.damage()->message, HasSubstr(expected));
    EXPECT_FALSE(reader.next(&event));
    ASSERT_TRUE(reader.resync());
    ASSERT_TRUE(reader.next(&event));
    EXPECT_EQ(event.channel, "C");
    EXPECT_EQ(event.offset_bytes, static_cast<std::int64_t>(head.size() + middle.size()));
    EXPECT_FALSE(reader.next(&event));
    EXPECT_FALSE(reader.damage());
  };
  const std::string good = event_bytes(1, 2, "B", "second");
  const auto with = [&](std::size_t at, const std::string& bytes) {
    return std::string(good).replace(at, bytes.size(), bytes);
  };
  damaged("garbage", "lead to byte 34, where no event begins");
  damaged(with(20, big_endian(-1, 4)), "a channel name of -1 bytes is impossible");
  damaged(with(20, big_endian(0, 4)), "a channel name of 0 bytes");
  damaged(with(24, big_endian(-5, 4)), "a message of -5 bytes is impossible");
  damaged(with(24, big_endian(2'000'000'000, 4)), "the event needs 2000000029 bytes");
  damaged(with(24, big_endian(7, 4)), "where no event begins");
}

TEST(LogReader, passes_over_a_sync_word_inside_a_message) {
  const TemporaryFolder folder;
  const std::string sync("\xED\xA1\xDA\x01", 4);
  write_file(folder / "s.lcm",
             "xx" + event_bytes(0, 1, "A", sync + "data" + sync) + event_bytes(1, 2, "B", sync));
  LogReader reader(folder / "s.lcm");
  LogEvent event;
  EXPECT_FALSE(reader.next(&event));
  EXPECT_THAT(reader.damage()->message, HasSubstr("byte 0: expected the sync bytes"));
  ASSERT_TRUE(reader.resync());
  ASSERT_TRUE(reader.next(&event));
  EXPECT_EQ(event.channel, "A");
  EXPECT_EQ(event.data.size(), 12U);
  ASSERT_TRUE(reader.next(&event));
  EXPECT_EQ(event.channel, "B");
}

TEST(LogReader, survives_any_damage_of_random_bytes) {
  const TemporaryFolder folder;
  std::string good;
  for (int i = 0; i < 30; ++i)
    good += event_bytes(i, i, "CHANNEL", std::string(static_cast<std::size_t>(i * 7), 'x'));
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round) {
    std::string bytes = good;
    for (int i = 0; i < 5; ++i)
      bytes[4 + random() % (bytes.size() - 4)] = static_cast<char>(random());
    write_file(folder / "r.lcm", bytes);
    LogReader reader(folder / "r.lcm");
    LogEvent event;
    int n_events = 0;
    std::int64_t last = -1;
    do {
      while (reader.next(&event)) {
        ++n_events;
        ASSERT_GT(event.offset_bytes, last);
        last = event.offset_bytes;
      }
    } while (reader.damage() && reader.resync());
    EXPECT_GE(n_events, 15) << round;  // each wrong byte costs two events at most
  }
}

TEST(LogReader, reads_a_real_log) {
  FS_RECORDING(path, "lidar/lcm-maebot-empty/empty_environment.log");
  LogReader reader(path);
  LogEvent event;
  std::map<std::string, int> n;
  while (reader.next(&event)) ++n[event.channel];
  EXPECT_FALSE(reader.damage());
  EXPECT_EQ(n["MAEBOT_LASER_SCAN"], 403);
  EXPECT_EQ(n["MAEBOT_MOTOR_FEEDBACK"], 1506);
  EXPECT_EQ(reader.offset_bytes(), reader.size_bytes());
}

}  // namespace
}  // namespace fusion_slam
