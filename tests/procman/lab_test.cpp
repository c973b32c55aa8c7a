// Deputies and sheriffs as processes on three machines (network namespaces joined by a bridge),
// with lossy links, cut links, forged orders, two sheriffs, and deputies that are killed.
#include <csignal>
#include <fstream>
#include <sstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "libs/authentication/signature.hpp"
#include "libs/bus/transport.hpp"
#include "libs/clock/clock.hpp"
#include "libs/messages/procman.hpp"
#include "procman/doctor/machines.hpp"
#include "tests/support/lab_network.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Json = nlohmann::json;

constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=1";
const char* const kMachines[] = {"robot", "vision", "mapping"};

std::string reason;
const std::unique_ptr<LabNetwork>& network() {
  static const std::unique_ptr<LabNetwork> kNetwork = LabNetwork::make(3, &reason);
  return kNetwork;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

template <class Condition>
bool soon(Condition condition, int seconds = 60) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  while (!condition()) {  // asked once more, a lossy network may say something else
    if (std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return true;
}

class LabTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!network()) GTEST_SKIP() << "skipped: " << reason;
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream(folder_ / "lab.cfg")
        << "group \"sensors\" { cmd \"driver\" { exec = \"sleep 1001\"; deputy = \"robot\"; "
           "auto_respawn = \"true\"; } }\n"
           "group \"services\" {\n"
           "  cmd \"seer\" { exec = \"sleep 1002\"; deputy = \"vision\"; auto_respawn = \"true\"; "
           "}\n"
           "  cmd \"mapper\" { exec = \"sh -c 'echo map; sleep 1003'\"; deputy = \"mapping\"; } }\n"
           "script \"start\" { start group \"services\" wait \"running\"; start everything wait "
           "\"running\"; }\n";
  }
  void TearDown() override {
    deputies_.clear();
    fs::remove_all(folder_);
    for (int machine = 0; network() && machine <= 3; ++machine) network()->disturb(machine, {});
  }

  Child deputy(int machine, std::vector<std::string> options = {}) {
    std::vector<std::string> argv{FS_BINARY_DIR "/bin/procman-deputy",
                                  "--name",
                                  kMachines[machine - 1],
                                  "--allow",
                                  "/usr/bin",
                                  "--allow",
                                  "/bin",
                                  "--lcm-url",
                                  kUrl};
    argv.insert(argv.end(), options.begin(), options.end());
    return {"deputy", network()->on(machine, argv),
            folder_ / (std::string(kMachines[machine - 1]) + ".log")};
  }
  void all_deputies(const std::vector<std::string>& options = {}) {
    for (int machine = 1; machine <= 3; ++machine) deputies_.push_back(deputy(machine, options));
  }
  Child start_lab(std::vector<std::string> arguments, const std::string& out, int machine = 0) {
    arguments.insert(arguments.begin(), {FS_BINARY_DIR "/bin/procman-sheriff", "--lcm-url", kUrl});
    return {"sheriff", network()->on(machine, arguments), folder_ / out};
  }
  // Its exit code; its output is in printed_.
  std::string lab(const std::vector<std::string>& arguments, int machine = 0) {
    fs::remove(folder_ / "sheriff.log");
    Child sheriff = start_lab(arguments, "sheriff.log", machine);
    soon([&] { return !sheriff.running(); }, 120);
    printed_ = text_of(folder_ / "sheriff.log");
    return sheriff.how_it_ended();
  }
  std::string config() const { return folder_ / "lab.cfg"; }
  Json status() {
    lab({"status", "--json"});
    return Json::parse(printed_, nullptr, false);
  }
  static std::string state(const Json& status, const std::string& name, int* pid = nullptr) {
    for (const auto& command : status.value("commands", Json::array())) {
      if (command["name"] != name) continue;
      if (pid != nullptr) *pid = command.value("pid", 0);
      return command["state"];
    }
    return "none";
  }

  fs::path folder_ = fs::path(testing::TempDir()) / ("lab_test_" + std::to_string(getpid()));
  std::vector<Child> deputies_;
  std::string printed_;
};

TEST_F(LabTest, StartsAndStopsOnLossySlowReorderingLinks) {
  for (int machine = 0; machine <= 3; ++machine) network()->disturb(machine, {0.1, 20.0, 15.0});
  all_deputies();
  EXPECT_EQ(lab({"run", config(), "start"}, 2), "exit code 0") << printed_;
  const Json running = status();
  for (const char* const name : {"driver", "seer", "mapper"})
    EXPECT_EQ(state(running, name), "running") << printed_;
  EXPECT_EQ(running["deputies"].size(), 3U);
  EXPECT_EQ(lab({"down", config()}), "exit code 0") << printed_;
  EXPECT_TRUE(status()["commands"].empty()) << printed_;
  EXPECT_GT(network()->lost_frames(), 0);
}

TEST_F(LabTest, ACutLinkStopsNothing) {
  all_deputies();
  ASSERT_EQ(lab({"up", config()}), "exit code 0") << printed_;
  int before = 0;
  state(status(), "seer", &before);
  Child watcher = start_lab({"status", "--watch"}, "watch.log");
  ASSERT_TRUE(soon([&] {
    return text_of(folder_ / "watch.log").find("seer     running") != std::string::npos;
  })) << text_of(folder_ / "watch.log");
  network()->cut(2);
  EXPECT_TRUE(
      soon([&] { return text_of(folder_ / "watch.log").find("SILENT") != std::string::npos; }));
  network()->join(2);
  watcher.stop(5000, SIGINT);
  int after = 0;
  EXPECT_TRUE(soon([&] { return state(status(), "seer", &after) == "running"; })) << printed_;
  EXPECT_EQ(before, after) << "it went on";
}

TEST_F(LabTest, AKilledDeputyGetsItsOrdersAgain) {
  all_deputies();
  Child sheriff = start_lab({"up", config(), "--watch"}, "up.log");
  int before = 0;
  ASSERT_TRUE(soon([&] { return state(status(), "driver", &before) == "running"; })) << printed_;
  kill(deputies_[0].pid(), SIGKILL);
  EXPECT_TRUE(soon([&] { return kill(before, 0) != 0; })) << "commands die with it";
  deputies_.push_back(deputy(1));
  int after = 0;
  EXPECT_TRUE(soon([&] { return state(status(), "driver", &after) == "running"; })) << printed_;
  EXPECT_NE(before, after);
}

TEST_F(LabTest, TheSecondSheriffIsToldSo) {
  all_deputies();
  Child first = start_lab({"up", config(), "--watch"}, "up.log");
  int before = 0;
  ASSERT_TRUE(soon([&] { return state(status(), "driver", &before) == "running"; })) << printed_;
  EXPECT_EQ(lab({"restart", config()}, 3), "exit code 1");
  EXPECT_THAT(printed_, HasSubstr("another sheriff is giving orders"));
  int after = 0;
  EXPECT_EQ(state(status(), "driver", &after), "running");
  EXPECT_EQ(before, after) << "nothing was restarted";
  first.stop(5000, SIGINT);
  EXPECT_EQ(lab({"down", config()}, 3), "exit code 0") << printed_;
}

TEST_F(LabTest, ForgedAndReplayedOrdersDoNothing) {
  std::ofstream(folder_ / "key") << "0123456789abcdef0123456789abcdef";
  fs::permissions(folder_ / "key", fs::perms::owner_read | fs::perms::owner_write);
  const std::string key = folder_ / "key";
  all_deputies({"--key", key});
  EXPECT_EQ(lab({"up", config(), "--timeout", "2"}), "exit code 1") << "no key";
  EXPECT_TRUE(status()["commands"].empty()) << printed_;
  std::vector<std::vector<std::uint8_t>> recorded;
  {
    Transport recorder(kUrl);
    const auto token = recorder.subscribe(
        "PM_ORDERS", [&](const std::string&, const std::uint8_t* bytes, std::size_t size) {
          recorded.emplace_back(bytes, bytes + size);
        });
    EXPECT_EQ(lab({"up", config(), "--key", key}), "exit code 0") << printed_;
    EXPECT_EQ(lab({"down", config(), "--key", key}), "exit code 0") << printed_;
  }
  ASSERT_GT(recorded.size(), 3U);
  Transport attacker(kUrl);
  const SigningKey wrong(std::vector<std::uint8_t>(16, 7));
  for (const auto& bytes : recorded) {
    attacker.publish("PM_ORDERS", bytes);
    const std::vector<std::uint8_t> plain(
        bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(
                                           size_without_signature(bytes.data(), bytes.size())));
    attacker.publish("PM_ORDERS", plain);
    attacker.publish("PM_ORDERS", wrong.sign("PM_ORDERS", plain));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_TRUE(status()["commands"].empty()) << printed_;
}

TEST_F(LabTest, MalformedMessagesHurtNobody) {
  all_deputies();
  ASSERT_EQ(lab({"up", config()}), "exit code 0") << printed_;
  {
    Transport attacker(kUrl);
    Orders orders{1, "robot", "x", {{}, {}}};
    const auto good = bus_detail::encode(to_message(orders));
    for (std::size_t i = 0; i < good.size(); ++i) {
      auto bytes = good;
      bytes[i] ^= 0x80;
      for (const char* const channel :
           {"PM_ORDERS", "PM_INFO", "PM_OUTPUT", "PM_DISCOVER", "CLOCK_PING"})
        attacker.publish(channel, bytes);
      bytes.resize(i);
      attacker.publish("PM_ORDERS", bytes);
    }
  }
  const Json after = status();
  for (const char* const name : {"driver", "seer", "mapper"})
    EXPECT_EQ(state(after, name), "running") << printed_;
}

TEST_F(LabTest, ASecondDeputyOfTheSameNameEnds) {
  deputies_.push_back(deputy(1));
  ASSERT_TRUE(soon([&] { return status()["deputies"].size() == 1; }));
  Child twin(
      "deputy",
      network()->on(2, {FS_BINARY_DIR "/bin/procman-deputy", "--name", "robot", "--lcm-url", kUrl}),
      folder_ / "twin.log");
  EXPECT_TRUE(soon([&] { return !twin.running(); }));
  EXPECT_EQ(twin.how_it_ended(), "exit code 1");
  EXPECT_THAT(text_of(folder_ / "twin.log"), HasSubstr("already"));
}

TEST_F(LabTest, OutputComesWithNames) {
  all_deputies();
  Child logs = start_lab({"logs", config()}, "logs.log");
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  ASSERT_EQ(lab({"up", config(), "services"}), "exit code 0") << printed_;
  EXPECT_TRUE(soon([&] {
    return text_of(folder_ / "logs.log").find("[mapping/mapper] map\n") != std::string::npos;
  }));
  EXPECT_EQ(lab({"up", config(), "nonsense"}), "exit code 1");
  EXPECT_THAT(printed_, HasSubstr("no command or group \"nonsense\""));
  Child missing = start_lab({"up", config(), "--timeout", "0.5"}, "missing.log");
  deputies_.clear();
}

TEST_F(LabTest, TheDoctorMeasuresClocksAndLoss) {
  network()->disturb(2, {0.4, 0.0, 0.0});
  all_deputies();
  ASSERT_TRUE(soon([&] { return status()["deputies"].size() == 3; })) << printed_;
  const auto results = check_machines(kUrl);
  ASSERT_EQ(results.size(), 3U);
  for (const CheckResult& result : results) {
    EXPECT_THAT(result.found, HasSubstr("clock"));
    if (result.name == "vision") {
      EXPECT_EQ(result.state, CheckState::kFault) << result.found;
    }
    EXPECT_THAT(result.command, testing::Not(HasSubstr("chrony"))) << "it is the same clock";
  }
}

TEST(Doctor, JudgesMachines) {
  EXPECT_EQ(judge_machines({}, 50).at(0).state, CheckState::kFault);
  const auto judged = [](int answered, double offset_ms, double uncertainty_ms) {
    return judge_machines({{"a", {answered, {offset_ms, uncertainty_ms, 1.0, 2.0}}}}, 50)
        .at(0)
        .state;
  };
  EXPECT_EQ(judged(50, 0.5, 0.3), CheckState::kGood);
  EXPECT_EQ(judged(50, 30.0, 30.0), CheckState::kGood) << "nothing is known";
  EXPECT_EQ(judged(50, -5.0, 0.3), CheckState::kWarning);
  EXPECT_EQ(judged(49, 0.0, 0.3), CheckState::kWarning);
  EXPECT_EQ(judged(50, -50.0, 0.3), CheckState::kFault);
  EXPECT_EQ(judged(40, 0.0, 0.3), CheckState::kFault);
}

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  fusion_slam::network();  // before any thread
  return RUN_ALL_TESTS();
}
