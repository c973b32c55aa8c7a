#include "libs/procman/command_machine.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

using Action = CommandMachine::Action;
constexpr std::int64_t kSecond = 1'000'000;

CommandSpec spec(bool auto_respawn = false) {
  CommandSpec result;
  result.id = "a";
  result.exec = "x";
  result.auto_respawn = auto_respawn;
  return result;
}

CommandMachine running(bool auto_respawn) {
  CommandMachine machine(spec(auto_respawn));
  machine.order({spec(auto_respawn), 1, false});
  EXPECT_EQ(machine.step(0), Action::kStart);
  machine.started(10, 0);
  EXPECT_EQ(machine.step(1), Action::kNothing);
  return machine;
}

TEST(CommandMachine, DoesNothingWithoutOrders) {
  CommandMachine machine(spec());
  EXPECT_EQ(machine.step(0), Action::kNothing);
  machine.order({spec(), 0, false});
  EXPECT_EQ(machine.step(0), Action::kNothing) << "the run that it has";
  machine.order({spec(), 5, true});
  EXPECT_EQ(machine.step(0), Action::kNothing) << "force_quit";
}

TEST(CommandMachine, StopsWithItsSignalThenKills) {
  CommandMachine machine = running(false);
  machine.order({spec(), 1, true});
  EXPECT_EQ(machine.step(kSecond), Action::kSignal);
  EXPECT_EQ(machine.step(kSecond + 1), Action::kNothing);
  EXPECT_EQ(machine.step(8 * kSecond - 1), Action::kNothing);
  EXPECT_EQ(machine.step(8 * kSecond), Action::kKill) << "7 s later";
  EXPECT_EQ(machine.step(9 * kSecond), Action::kNothing) << "once";
  machine.exited(9, 9 * kSecond);
  EXPECT_EQ(machine.status().exit_code, 9);
  EXPECT_EQ(machine.step(10 * kSecond), Action::kNothing);
}

TEST(CommandMachine, ANewRunidRestarts) {
  CommandMachine machine = running(false);
  machine.order({spec(), 2, false});
  EXPECT_EQ(machine.step(1), Action::kSignal);
  EXPECT_EQ(machine.status().actual_runid, 1);
  machine.exited(2, 2);
  EXPECT_EQ(machine.step(3), Action::kStart);
  machine.started(11, 3);
  EXPECT_EQ(machine.status().actual_runid, 2);
  EXPECT_EQ(machine.step(4), Action::kNothing);
}

// As procman's sheriff orders before it has heard the deputy, and as it asks for one to stop.
TEST(CommandMachine, Runid0LeavesItAsItIs) {
  CommandMachine machine = running(false);
  machine.order({spec(), 0, false});
  EXPECT_EQ(machine.step(1), Action::kNothing);
  EXPECT_EQ(machine.status().actual_runid, 1);
  machine.order({spec(), 2, false});
  EXPECT_EQ(machine.step(2), Action::kSignal) << "a new one is another run";
}

TEST(CommandMachine, OneStoppedBeforeItWasStartedIsOver) {
  CommandMachine machine(spec());
  machine.order({spec(), 5, true});
  EXPECT_EQ(machine.step(0), Action::kNothing);
  EXPECT_EQ(machine.status().actual_runid, 5) << "or procman's sheriff waits for it";
  EXPECT_EQ(machine.status().pid, 0);
}

// As procman's sheriff orders when a script stops a command whose runid it has not heard yet.
TEST(CommandMachine, OneStoppedWithRunid0IsOverToTheSheriffThatAsked) {
  CommandMachine machine = running(false);
  machine.order({spec(), 0, true});
  EXPECT_EQ(machine.step(1), Action::kSignal);
  machine.order({spec(), 0, true});
  EXPECT_EQ(machine.status().actual_runid, 1) << "while it still runs";
  machine.exited(2, 2);
  machine.order({spec(), 0, true});
  EXPECT_EQ(machine.status().actual_runid, 0) << "or procman's sheriff waits for it";
  EXPECT_EQ(machine.step(3), Action::kNothing);
  machine.order({spec(), 0, false});
  EXPECT_EQ(machine.step(4), Action::kNothing) << "0 starts nothing";
  machine.order({spec(), 1, false});
  EXPECT_EQ(machine.step(5), Action::kStart) << "the sheriff counts on from 0";
}

TEST(CommandMachine, OneThatEndsStaysEndedUnlessItShallRespawn) {
  CommandMachine machine = running(false);
  machine.exited(0, 5);
  EXPECT_EQ(machine.step(100 * kSecond), Action::kNothing);
}

TEST(CommandMachine, RespawnsWithLongerAndLongerPauses) {
  CommandMachine machine = running(true);
  std::int64_t now = 1;
  std::vector<std::int64_t> pauses;
  for (int i = 0; i < 12; ++i) {
    machine.exited(1, now);
    const std::int64_t ended = now;
    while (machine.step(now) != Action::kStart) now += 1000;
    pauses.push_back(now - ended);
    machine.started(20 + i, now);
  }
  for (std::size_t i = 0; i < pauses.size(); ++i)
    EXPECT_NEAR(static_cast<double>(pauses[i]),
                static_cast<double>(std::min<std::int64_t>(50'000LL << i, 10 * kSecond)), 1000.0)
        << i;
  now += 11 * kSecond;  // a good run
  machine.exited(1, now);
  EXPECT_EQ(machine.step(now + 49'000), Action::kNothing);
  EXPECT_EQ(machine.step(now + 50'000), Action::kStart);
}

TEST(CommandMachine, AnOrderToStopEndsRespawning) {
  CommandMachine machine = running(true);
  machine.exited(1, 10);
  machine.order({spec(true), 1, true});
  EXPECT_EQ(machine.step(100 * kSecond), Action::kNothing);
}

TEST(CommandMachine, OneThatCannotBeStartedIsNotTriedForEver) {
  CommandMachine machine(spec());
  machine.order({spec(), 1, false});
  EXPECT_EQ(machine.step(0), Action::kStart);
  machine.could_not_start(0);
  EXPECT_EQ(machine.status().exit_code, 127 << 8);
  EXPECT_EQ(machine.step(100 * kSecond), Action::kNothing);
  machine.order({spec(), 2, false});
  EXPECT_EQ(machine.step(100 * kSecond), Action::kStart);
}

TEST(CommandMachine, RemovedMeansStoppedThenGone) {
  CommandMachine machine = running(true);
  machine.remove();
  EXPECT_FALSE(machine.removable());
  EXPECT_EQ(machine.step(1), Action::kSignal);
  machine.exited(2, 2);
  EXPECT_TRUE(machine.removable());
  EXPECT_EQ(machine.step(100 * kSecond), Action::kNothing);
}

}  // namespace
}  // namespace fusion_slam
