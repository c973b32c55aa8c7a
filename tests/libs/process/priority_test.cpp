#include "libs/process/priority.hpp"

#include <thread>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

int niceness() { return getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())); }

TEST(Priority, OnlyTheThreadGivesWay) {
  const int before = niceness();
  int its = 0;
  std::thread([&its] {
    give_way();
    its = niceness();
  }).join();
  EXPECT_EQ(its, 10);
  EXPECT_EQ(niceness(), before);
}

}  // namespace
}  // namespace fusion_slam
