// Sheriff and deputy as pure state machines, with messages between them that get lost.
#include <map>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "libs/messages/procman.hpp"
#include "libs/procman/deputy_core.hpp"
#include "libs/procman/script_runner.hpp"
#include "libs/procman/sheriff_core.hpp"
#include "libs/procman/status_table.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;
constexpr std::int64_t kSecond = 1'000'000;
constexpr std::int64_t kUtime = 1'700'000'000'000'000;

LabConfig two_commands() {
  return parse_lab_config(
      "group \"g\" { cmd \"a\" { exec = \"x\"; deputy = \"d\"; auto_respawn = \"true\"; }"
      "  cmd \"b\" { exec = \"y\"; deputy = \"d\"; } }"
      "script \"go\" { start cmd \"a\" wait \"running\"; wait ms 2000; run_script \"more\"; }"
      "script \"more\" { start group \"g\"; stop cmd \"a\" wait \"stopped\"; }",
      "test");
}

Orders orders(std::int64_t utime_us, const std::string& sheriff = "s") {
  return {utime_us, "d", sheriff, {{two_commands().commands[0].spec, 1, false}}};
}

TEST(DeputyCore, TakesOnlyOrdersItShould) {
  DeputyCore deputy("d");
  Orders foreign = orders(kUtime);
  foreign.deputy = "e";
  EXPECT_EQ(deputy.take(foreign, kUtime, 0), OrdersVerdict::kForAnother);
  EXPECT_EQ(deputy.take(orders(kUtime - 61 * kSecond), kUtime, 0), OrdersVerdict::kTooOld);
  EXPECT_EQ(deputy.take(orders(kUtime + 61 * kSecond), kUtime, 0), OrdersVerdict::kTooOld);
  EXPECT_EQ(deputy.take(orders(std::numeric_limits<std::int64_t>::max()), kUtime, 0),
            OrdersVerdict::kTooOld);
  EXPECT_EQ(deputy.take(orders(kUtime), kUtime, 0), OrdersVerdict::kTaken);
  EXPECT_EQ(deputy.take(orders(kUtime), kUtime, 0), OrdersVerdict::kOlder) << "replayed";
  EXPECT_EQ(deputy.take(orders(kUtime - 1), kUtime, 0), OrdersVerdict::kOlder);
  EXPECT_EQ(deputy.take(orders(kUtime + 1), kUtime, 0), OrdersVerdict::kTaken);
}

TEST(DeputyCore, ObeysOneSheriffAtATime) {
  DeputyCore deputy("d");
  EXPECT_EQ(deputy.take(orders(kUtime), kUtime, 0), OrdersVerdict::kTaken);
  EXPECT_EQ(deputy.take(orders(kUtime + 1, "t"), kUtime, 2 * kSecond),
            OrdersVerdict::kOtherSheriff);
  EXPECT_EQ(deputy.take(orders(kUtime + 2, "t"), kUtime, 4 * kSecond), OrdersVerdict::kTaken);
  deputy.sheriff_left("s");  // long gone: says nothing of t
  EXPECT_EQ(deputy.take(orders(kUtime + 3), kUtime, 5 * kSecond), OrdersVerdict::kOtherSheriff);
  deputy.sheriff_left("t");
  EXPECT_EQ(deputy.take(orders(kUtime + 3), kUtime, 5 * kSecond), OrdersVerdict::kTaken);
}

TEST(DeputyCore, OneThatWantsSignaturesTakesNothingFromBeforeItsStart) {
  DeputyCore deputy("d", kUtime);
  EXPECT_EQ(deputy.take(orders(kUtime - 1), kUtime, 0), OrdersVerdict::kOlder);
  EXPECT_EQ(deputy.take(orders(kUtime + 1), kUtime, 0), OrdersVerdict::kTaken);
}

TEST(DeputyCore, KnowsNoMoreThanAThousandCommands) {
  DeputyCore deputy("d");
  Orders many = orders(kUtime);
  many.commands.clear();
  for (int i = 0; i < 3000; ++i) {
    DesiredCommand command;
    command.spec.id = std::to_string(i);
    many.commands.push_back(command);
  }
  deputy.take(many, kUtime, 0);
  EXPECT_EQ(deputy.commands().size(), 1000U);
}

// A machine without processes: what is started runs, what is signalled ends.
struct FakeMachine {
  DeputyCore core{"d"};
  std::int32_t next_pid = 100;
  int starts = 0;

  void work(std::int64_t now_us) {
    for (const auto& step : core.steps(now_us)) {
      CommandMachine& command = *core.find(step.id);
      if (step.action == CommandMachine::Action::kStart) {
        command.started(next_pid++, now_us);
        ++starts;
      } else {
        command.exited(2, now_us);
      }
    }
    core.steps(now_us);
  }
  DeputyInfo info(std::int64_t utime_us) const {
    DeputyInfo result;
    result.utime_us = utime_us;
    result.deputy = "d";
    for (const auto& [id, machine] : core.commands()) result.commands.push_back(machine.status());
    return result;
  }
};

// A second of both, by way of the wire's types; each message is lost with this probability.
struct Lab {
  SheriffCore sheriff{"s"};
  FakeMachine machine;
  std::mt19937 rng{1};
  double loss = 0.0;
  std::int64_t now = 0;

  bool arrives() { return std::uniform_real_distribution<double>(0, 1)(rng) >= loss; }
  void second() {
    now += kSecond;
    for (const Orders& wanted : sheriff.orders(kUtime + now))
      if (arrives()) machine.core.take(from_message(to_message(wanted)), kUtime + now, now);
    machine.work(now);
    if (arrives())
      sheriff.hear(from_message(to_message(machine.info(kUtime + now))), kUtime + now, now);
  }
  CommandState state(const std::string& id) { return sheriff.commands().at(id).state(); }
};

TEST(Cores, StartStopRestartRemove) {
  Lab lab;
  lab.sheriff.load(two_commands());
  EXPECT_EQ(lab.state("a"), CommandState::kUnknown);
  for (int i = 0; i < 3; ++i) lab.second();
  EXPECT_EQ(lab.state("a"), CommandState::kStoppedWell);
  lab.sheriff.start("a");
  EXPECT_EQ(lab.state("a"), CommandState::kStarting);
  lab.second();
  EXPECT_EQ(lab.state("a"), CommandState::kRunning);
  lab.sheriff.start("a");
  lab.second();
  EXPECT_EQ(lab.machine.starts, 1) << "it ran already";
  lab.sheriff.restart("a");
  EXPECT_EQ(lab.state("a"), CommandState::kRestarting);
  lab.second();
  lab.second();
  EXPECT_EQ(lab.state("a"), CommandState::kRunning);
  EXPECT_EQ(lab.machine.starts, 2);
  lab.sheriff.stop("a");
  EXPECT_EQ(lab.state("a"), CommandState::kStopping);
  lab.second();
  lab.second();
  EXPECT_EQ(lab.state("a"), CommandState::kStoppedWell) << "the signal was asked for";
  lab.sheriff.remove("a");
  lab.second();
  lab.second();
  EXPECT_EQ(lab.sheriff.commands().count("a"), 0U);
  EXPECT_EQ(lab.sheriff.commands().count("b"), 1U);
}

TEST(Cores, ANewSheriffFindsAllAsItWas) {
  Lab lab;
  lab.sheriff.load(two_commands());
  lab.second();
  lab.sheriff.start("a");
  lab.second();
  lab.second();
  lab.sheriff = SheriffCore("s2");
  lab.now += 4 * kSecond;
  lab.sheriff.load(two_commands());
  for (int i = 0; i < 3; ++i) lab.second();
  EXPECT_EQ(lab.state("a"), CommandState::kRunning);
  EXPECT_EQ(lab.machine.starts, 1) << "not started again";
  lab.sheriff = SheriffCore("s3");  // one that knows no configuration adopts what runs
  lab.now += 4 * kSecond;
  for (int i = 0; i < 3; ++i) lab.second();
  EXPECT_EQ(lab.state("a"), CommandState::kRunning);
  EXPECT_EQ(lab.machine.starts, 1);
}

TEST(Cores, ADeputyStartedAnewIsToldAgain) {
  Lab lab;
  lab.sheriff.load(two_commands());
  lab.second();
  lab.sheriff.start("a");
  lab.second();
  lab.second();
  lab.machine = FakeMachine();
  for (int i = 0; i < 3; ++i) lab.second();
  EXPECT_EQ(lab.state("a"), CommandState::kRunning);
  EXPECT_EQ(lab.machine.starts, 1);
}

// Whatever is lost on the way: when it has been quiet for a while, all is as the sheriff wants, and
// nothing was started more often than ordered.
TEST(Cores, LossOnlyCostsTime) {
  for (const double loss : {0.0, 0.05, 0.2, 0.6}) {
    Lab lab;
    lab.loss = loss;
    lab.rng.seed(7);
    lab.sheriff.load(two_commands());
    while (lab.sheriff.deputies().empty()) lab.second();
    int ordered = 0;
    for (int i = 0; i < 200; ++i) {
      const std::string id = lab.rng() % 2 == 0 ? "a" : "b";
      switch (lab.rng() % 4) {
        case 0:
          lab.sheriff.start(id);
          ++ordered;
          break;
        case 1:
          lab.sheriff.restart(id);
          ++ordered;
          break;
        case 2:
          lab.sheriff.stop(id);
          break;
        default:
          break;
      }
      lab.second();
    }
    for (int i = 0; i < 60; ++i) lab.second();
    for (const auto& [id, command] : lab.sheriff.commands()) {
      const CommandMachine* machine = lab.machine.core.find(id);
      ASSERT_NE(machine, nullptr);
      EXPECT_EQ(machine->status().pid != 0, !command.force_quit) << id << " at loss " << loss;
      EXPECT_EQ(command.state(),
                command.force_quit ? CommandState::kStoppedWell : CommandState::kRunning)
          << id << " at loss " << loss;
    }
    EXPECT_LE(lab.machine.starts, ordered);
    EXPECT_GT(lab.machine.starts, 10);
  }
}

TEST(ScriptRunner, RunsEveryAction) {
  Lab lab;
  lab.sheriff.load(two_commands());
  lab.second();
  ScriptRunner script(two_commands(), "go");
  EXPECT_FALSE(script.step(&lab.sheriff, lab.now));
  EXPECT_EQ(script.waiting_for(), "start cmd \"a\" wait \"running\"");
  lab.second();
  EXPECT_FALSE(script.step(&lab.sheriff, lab.now));
  EXPECT_EQ(script.waiting_for(), "wait ms 2000");
  lab.second();
  EXPECT_FALSE(script.step(&lab.sheriff, lab.now));
  lab.second();
  EXPECT_FALSE(script.step(&lab.sheriff, lab.now));
  EXPECT_EQ(script.waiting_for(), "stop cmd \"a\" wait \"stopped\"");
  lab.second();
  lab.second();
  EXPECT_TRUE(script.step(&lab.sheriff, lab.now));
  EXPECT_EQ(lab.state("b"), CommandState::kRunning);
  EXPECT_EQ(lab.state("a"), CommandState::kStoppedWell);
  EXPECT_THROW(ScriptRunner(two_commands(), "none"), LabConfigError);
}

// A script has no time-out: one that waited for a short command would wait for ever.
TEST(ScriptRunner, ACommandThatHasEndedWasRunning) {
  Lab lab;
  lab.sheriff.load(two_commands());
  lab.second();
  EXPECT_FALSE(lab.sheriff.all({"a"}, WaitFor::kRunning));
  lab.sheriff.start({"a"});
  lab.second();
  lab.second();
  EXPECT_TRUE(lab.sheriff.all({"a"}, WaitFor::kRunning));
  EXPECT_FALSE(lab.sheriff.all({"a"}, WaitFor::kStopped));
  lab.sheriff.stop({"a"});
  lab.second();
  lab.second();
  EXPECT_TRUE(lab.sheriff.all({"a"}, WaitFor::kStopped));
  EXPECT_TRUE(lab.sheriff.all({"a"}, WaitFor::kRunning));
}

TEST(StatusTable, SaysWhatPeopleNeed) {
  SheriffCore sheriff("s");
  EXPECT_THAT(status_table(sheriff, 0), HasSubstr("no deputy heard"));
  LabConfig config = two_commands();
  config.commands[1].deputy = "elsewhere";
  sheriff.load(config);
  DeputyInfo info;
  info.deputy = "d";
  info.utime_us = kUtime;
  info.load.cpu_load = 0.25F;
  CommandStatus status;
  status.spec = config.commands[0].spec;
  status.actual_runid = 1;
  status.exit_code = 11;
  info.commands = {status};
  sheriff.hear(info, kUtime, kSecond);
  const std::string table = status_table(sheriff, 2 * kSecond);
  EXPECT_THAT(table, HasSubstr("d       1.0 s ago  25 %"));
  EXPECT_THAT(table, HasSubstr("FAILED"));
  EXPECT_THAT(table, HasSubstr("signal 11 (Segmentation fault)"));
  EXPECT_THAT(table, HasSubstr("no such deputy heard"));
  EXPECT_THAT(status_table(sheriff, 9 * kSecond), HasSubstr("SILENT for 8 s"));
  EXPECT_THAT(status_json(sheriff, 2 * kSecond), HasSubstr("\"state\": \"FAILED\""));
}

}  // namespace
}  // namespace fusion_slam
