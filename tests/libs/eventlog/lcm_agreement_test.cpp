// liblcm's own log functions, lcm-logger and lcm-logplayer read what we write, and we read what
// they write.
#include <memory>

#include <gtest/gtest.h>
#include <lcm/eventlog.h>

#include "libs/eventlog/reader.hpp"
#include "libs/eventlog/writer.hpp"
#include "tests/libs/eventlog/files.hpp"
#include "tests/libs/netcheck/private_network.hpp"

namespace fusion_slam {
namespace {

std::string payload(int i) {
  return std::string(static_cast<std::size_t>(i * 1000), static_cast<char>('a' + i));
}
constexpr int kEvents = 20;
constexpr std::int64_t kStart_us = 1'700'000'000'000'000;

void write_log(const std::filesystem::path& path) {
  LogWriter writer(path);
  for (int i = 0; i < kEvents; ++i)
    writer.write(kStart_us + 1000 * i, "CHANNEL_" + std::to_string(i % 3), to_bytes(payload(i)));
  writer.close();
}

TEST(LcmAgreement, liblcm_reads_our_logs) {
  const TemporaryFolder folder;
  write_log(folder / "ours.lcm");
  lcm_eventlog_t* log = lcm_eventlog_create((folder / "ours.lcm").c_str(), "r");
  ASSERT_NE(log, nullptr);
  for (int i = 0; i < kEvents; ++i) {
    lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log);
    ASSERT_NE(event, nullptr) << i;
    EXPECT_EQ(event->eventnum, i);
    EXPECT_EQ(event->timestamp, kStart_us + 1000 * i);
    EXPECT_EQ(std::string(event->channel), "CHANNEL_" + std::to_string(i % 3));
    EXPECT_EQ(std::string(static_cast<const char*>(event->data),
                          static_cast<std::size_t>(event->datalen)),
              payload(i));
    lcm_eventlog_free_event(event);
  }
  EXPECT_EQ(lcm_eventlog_read_next_event(log), nullptr);
  lcm_eventlog_destroy(log);
}

TEST(LcmAgreement, liblcm_writes_the_same_bytes) {
  const TemporaryFolder folder;
  write_log(folder / "ours.lcm");
  lcm_eventlog_t* log = lcm_eventlog_create((folder / "theirs.lcm").c_str(), "w");
  ASSERT_NE(log, nullptr);
  for (int i = 0; i < kEvents; ++i) {
    std::string channel = "CHANNEL_" + std::to_string(i % 3);
    std::string data = payload(i);
    lcm_eventlog_event_t event{};
    event.timestamp = kStart_us + 1000 * i;
    event.channellen = static_cast<std::int32_t>(channel.size());
    event.channel = channel.data();
    event.datalen = static_cast<std::int32_t>(data.size());
    event.data = data.data();
    ASSERT_EQ(lcm_eventlog_write_event(log, &event), 0);
  }
  lcm_eventlog_destroy(log);
  EXPECT_EQ(read_file(folder / "theirs.lcm"), read_file(folder / "ours.lcm"));
}

// 434CFFEF in /proc/net/igmp: the logger has joined 239.255.76.67.
TEST(LcmAgreement, logplayer_plays_our_log_and_we_read_what_logger_records) {
  if (run_shell("command -v lcm-logger && command -v lcm-logplayer").exit_code != 0) {
    GTEST_SKIP()
        << "skipped: lcm-logger and lcm-logplayer are not installed (apt install liblcm-bin)";
  }
  const TemporaryFolder folder;
  write_log(folder / "ours.lcm");
  const std::string recorded = (folder / "recorded.lcm").string();
  const auto result = in_private_network(
      with_multicast() + "lcm-logger --lcm-url=udpm:// --flush-interval=50 -f " + recorded +
      " & logger=$!\n"
      "for i in $(seq 100); do grep -q 434CFFEF /proc/net/igmp && break; sleep 0.1; done\n"
      "lcm-logplayer --lcm-url=udpm:// " +
      (folder / "ours.lcm").string() +
      "\n"
      "sleep 0.5\n"  // everything is in the logger's socket already; lcm-logger tells nobody when
                     // it has read it
      "kill -INT $logger; wait $logger\n");
  if (!result) GTEST_SKIP() << "skipped: a private network (unshare --net) is not permitted here";
  ASSERT_EQ(result->exit_code, 0) << result->output;
  LogReader reader(recorded);
  LogEvent event;
  int i = 0;
  while (reader.next(&event)) {
    if (event.channel.rfind("CHANNEL_", 0) != 0) continue;
    EXPECT_EQ(event.channel, "CHANNEL_" + std::to_string(i % 3));
    EXPECT_EQ(event.data, to_bytes(payload(i)));
    ++i;
  }
  EXPECT_FALSE(reader.damage());
  EXPECT_EQ(i, kEvents) << result->output;
}

}  // namespace
}  // namespace fusion_slam
