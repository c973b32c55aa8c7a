#include "libs/process/child.hpp"

#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

std::filesystem::path log_file(const std::string& name) {
  const auto path = std::filesystem::path(testing::TempDir()) / ("child_" + name + ".log");
  std::filesystem::remove(path);
  return path;
}

bool ends_soon(Child& child) {
  for (int i = 0; i < 500 && child.running(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return !child.running();
}

TEST(Child, SaysHowItEndedAndWhatItPrinted) {
  Child child("shell", {"/bin/sh", "-c", "echo one; echo two >&2; exit 3"}, log_file("ended"));
  ASSERT_TRUE(ends_soon(child));
  EXPECT_EQ(child.how_it_ended(), "exit code 3");
  EXPECT_FALSE(child.ended_well());
  EXPECT_EQ(child.last_lines(1), "    two\n");
}

TEST(Child, AProgramThatDoesNotExistSaysSo) {
  Child child("ghost", {"/nonexistent/ghost"}, log_file("ghost"));
  ASSERT_TRUE(ends_soon(child));
  EXPECT_NE(child.last_lines(20).find("cannot start /nonexistent/ghost"), std::string::npos);
}

TEST(Child, StopAsksAndThenForces) {
  Child polite("polite", {"/bin/sleep", "100"}, log_file("polite"));
  EXPECT_TRUE(polite.stop(2000));
  EXPECT_EQ(polite.how_it_ended(), "signal 15 (Terminated)");
  Child deaf("deaf", {"/bin/sh", "-c", "trap '' TERM; echo ready; while :; do sleep 0.1; done"},
             log_file("deaf"));
  for (int i = 0; i < 300 && deaf.last_lines(1).find("ready") == std::string::npos; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_FALSE(deaf.stop(100));
  EXPECT_EQ(deaf.how_it_ended(), "signal 9 (Killed)");
}

TEST(Child, DiesWithItsParent) {
  const auto path = log_file("orphan");
  const pid_t parent = fork();
  if (parent == 0) {
    Child child("orphan", {"/bin/sh", "-c", "echo $$; exec sleep 100"}, path);
    for (int i = 0; i < 300 && child.last_lines(1).find("printed nothing") != std::string::npos;
         ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    kill(getpid(), SIGKILL);
  }
  waitpid(parent, nullptr, 0);
  std::ifstream file(path);
  pid_t orphan = 0;
  ASSERT_TRUE(file >> orphan);
  // Gone, or a zombie that whoever adopted it has not collected yet.
  const auto gone = [&] {
    std::ifstream stat("/proc/" + std::to_string(orphan) + "/stat");
    std::string text;
    return !std::getline(stat, text) || text.find(") Z ") != std::string::npos;
  };
  for (int i = 0; i < 300 && !gone(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_TRUE(gone());
}

}  // namespace
}  // namespace fusion_slam
