// A deputy with real processes, without a network.
#include "procman/deputy/deputy.hpp"

#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

using testing::HasSubstr;

std::int64_t monotonic_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

class DeputyTest : public testing::Test {
 protected:
  DeputyTest() : deputy_(options(), 0) {}

  static DeputyOptions options() {
    DeputyOptions result;
    result.name = "d";
    result.allowed.folders = {"/usr/bin", "/bin"};
    return result;
  }

  void order(const std::string& exec, int runid, bool force_quit = false, double stop_time_s = 7.0,
             bool auto_respawn = false) {
    DesiredCommand command;
    command.spec.id = "c";
    command.spec.exec = exec;
    command.spec.stop_time_allowed_s = stop_time_s;
    command.spec.auto_respawn = auto_respawn;
    command.desired_runid = runid;
    command.force_quit = force_quit;
    ++utime_;
    ASSERT_EQ(deputy_.core().take({utime_, "d", "s", {command}}, utime_, monotonic_us()),
              OrdersVerdict::kTaken);
  }
  template <class Condition>
  bool until(Condition condition) {
    for (int i = 0; i < 6000 && !condition(); ++i) {
      deputy_.work(monotonic_us());
      for (const CommandOutput& output : deputy_.take_output()) printed_ += output.text;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return condition();
  }
  CommandStatus status() { return deputy_.core().find("c")->status(); }
  bool ended() { return status().pid == 0 && status().actual_runid != 0; }
  bool printed(const std::string& text) { return printed_.find(text) != std::string::npos; }

  std::int64_t utime_ = 1'700'000'000'000'000;
  Deputy deputy_;
  std::string printed_;
};

bool exists(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(file, text);
  return file && text.find(") Z") == std::string::npos;
}

TEST_F(DeputyTest, RunsAndReportsOutputAndExitCode) {
  order("sh -c 'echo hello; echo error >&2; exit 3'", 1);
  ASSERT_TRUE(until([&] { return ended(); }));
  EXPECT_EQ(status().exit_code, 3 << 8);
  EXPECT_EQ(printed_, "hello\nerror\n");
}

TEST_F(DeputyTest, StopsWithTheSignal) {
  order("sh -c 'trap \"echo bye; exit 0\" INT; echo ready; while true; do sleep 0.05; done'", 1);
  ASSERT_TRUE(until([&] { return printed("ready"); }));
  order("sh", 1, true);
  ASSERT_TRUE(until([&] { return ended(); }));
  EXPECT_THAT(printed_, HasSubstr("bye"));
  EXPECT_EQ(status().exit_code, 0);
}

TEST_F(DeputyTest, KillsWhatDoesNotStopWithAllItStarted) {
  order(
      "sh -c 'trap \"\" INT; sleep 1000 & echo child $!.; echo ready; while true; do sleep 1; "
      "done'",
      1, false, 0.2);
  ASSERT_TRUE(until([&] { return printed("ready"); }));
  const pid_t child = std::stoi(printed_.substr(printed_.find("child ") + 6));
  ASSERT_TRUE(exists(child));
  order("sh", 1, true, 0.2);
  ASSERT_TRUE(until([&] { return ended(); }));
  EXPECT_EQ(status().exit_code, SIGKILL);
  EXPECT_TRUE(until([&] { return !exists(child); })) << "the group was killed and reaped";
}

TEST_F(DeputyTest, WhatACommandLeavesBehindIsEndedAndReaped) {
  order("sh -c 'sleep 1000 & echo child $!.; exit 0'", 1);
  ASSERT_TRUE(until([&] { return ended(); }));
  const pid_t child = std::stoi(printed_.substr(printed_.find("child ") + 6));
  EXPECT_TRUE(until([&] { return kill(child, 0) != 0; })) << "not even a zombie is left";
}

TEST_F(DeputyTest, StartsAgainWhatWasKilled) {
  order("sleep 1000", 1, false, 7.0, true);
  ASSERT_TRUE(until([&] { return status().pid != 0; }));
  const pid_t first = status().pid;
  kill(first, SIGKILL);
  ASSERT_TRUE(until([&] { return status().pid != 0 && status().pid != first; }));
  EXPECT_EQ(status().actual_runid, 1) << "the same run, as the sheriff sees it";
  deputy_.core().stop_all();
  EXPECT_TRUE(until([&] { return !deputy_.core().any_running(); }));
}

TEST_F(DeputyTest, AFrozenProcessIsStoppedToo) {
  order("sleep 1000", 1);
  ASSERT_TRUE(until([&] { return status().pid != 0; }));
  kill(status().pid, SIGSTOP);
  order("sleep 1000", 1, true);
  EXPECT_TRUE(until([&] { return ended(); }));
  EXPECT_EQ(status().exit_code, SIGINT);
}

TEST_F(DeputyTest, SaysWhyItDoesNotStart) {
  order("LD_PRELOAD=/tmp/x.so sleep 1", 1);
  ASSERT_TRUE(until([&] { return ended() && printed("not started"); }));
  EXPECT_THAT(printed_, HasSubstr("LD_PRELOAD"));
  EXPECT_EQ(status().exit_code, 127 << 8);
  order("no-such-program", 2);
  ASSERT_TRUE(until([&] { return printed("no program no-such-program"); }));
  order("'", 3);
  ASSERT_TRUE(until([&] { return printed("not closed"); }));
}

TEST_F(DeputyTest, AFloodOfOutputIsCutAndSaidSo) {
  order(
      "sh -c 'i=0; while [ $i -lt 300 ]; do printf \"%02000d\\n\" $i; i=$((i+1)); done; sleep "
      "1000'",
      1);
  EXPECT_TRUE(until([&] { return printed("bytes left out"); }));
  EXPECT_LT(printed_.size(), 500'000U);
}

TEST_F(DeputyTest, MeasuresMemory) {
  order("sleep 1000", 1);
  ASSERT_TRUE(until([&] { return status().pid != 0; }));
  deputy_.measure();
  EXPECT_GT(status().rss_bytes, 0);
  EXPECT_GT(status().vsize_bytes, status().rss_bytes);
  const DeputyInfo info = deputy_.info(5);
  EXPECT_GT(info.load.memory_total_bytes, info.load.memory_free_bytes);
  EXPECT_GE(info.load.cpu_load, 0.0F);
  EXPECT_LE(info.load.cpu_load, 1.0F);
}

}  // namespace
}  // namespace fusion_slam
