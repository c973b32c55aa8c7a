#include "libs/bus/reset_gate.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

command_t reset(std::int64_t utime, const std::string& target = "") {
  command_t command{};
  command.utime = utime;
  command.verb = "reset";
  command.target = target;
  return command;
}

TEST(ResetGate, WhatWasMeasuredBeforeTheResetIsStale) {
  ResetGate gate("fuser");
  EXPECT_TRUE(gate.passes(0));
  EXPECT_TRUE(gate.passes(1'000));
  EXPECT_TRUE(gate.asks(reset(2'000)));
  EXPECT_FALSE(gate.passes(1'500));
  EXPECT_FALSE(gate.passes(2'000));
  EXPECT_TRUE(gate.passes(2'001));
}

TEST(ResetGate, OnlyThisProcessAndOnlyReset) {
  ResetGate gate("fuser");
  EXPECT_FALSE(gate.asks(reset(1, "viewer")));
  EXPECT_TRUE(gate.asks(reset(1, "fuser")));
  command_t finish = reset(1);
  finish.verb = "finish";
  EXPECT_FALSE(gate.asks(finish));
}

TEST(ResetGate, AClockFarAheadOfTheSensorsShutsNobodyUp) {
  ResetGate gate("fuser");
  gate.passes(5'000'000);
  EXPECT_TRUE(gate.asks(reset(1'700'000'000'000'000)));
  EXPECT_FALSE(gate.passes(5'000'000));
  EXPECT_TRUE(gate.passes(5'000'001));
}

}  // namespace
}  // namespace fusion_slam
