#include "libs/procman/lab_config.hpp"

#include <filesystem>
#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

LabConfig example() { return load_lab_config(FS_SOURCE_DIR "/tests/libs/procman/example.cfg"); }

std::string problem(const std::string& text) {
  try {
    parse_lab_config(text, "lab.cfg");
  } catch (const LabConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(LabConfig, ReadsAllAFileMayHold) {
  const LabConfig config = example();
  ASSERT_EQ(config.commands.size(), 3U);
  EXPECT_EQ(config.commands[0].spec.exec, "configure_robot \"two words\"");
  EXPECT_EQ(config.commands[0].deputy, "robot");
  EXPECT_EQ(config.commands[0].spec.stop_signal, 2);
  EXPECT_EQ(config.commands[0].spec.stop_time_allowed_s, 7.0);
  EXPECT_TRUE(config.commands[1].spec.auto_respawn);
  EXPECT_EQ(config.commands[2].spec.group, "hardware drivers/cameras");
  EXPECT_EQ(config.commands[2].spec.stop_signal, 15);
  EXPECT_EQ(config.commands[2].spec.stop_time_allowed_s, 20.0);
  ASSERT_EQ(config.scripts.size(), 2U);
  const auto& go = config.scripts[0].actions;
  ASSERT_EQ(go.size(), 6U);
  using Kind = ScriptAction::Kind;
  EXPECT_EQ(go[0].kind, Kind::kStart);
  EXPECT_EQ(go[0].wait_for, WaitFor::kStopped);
  EXPECT_EQ(go[1].target.name, "hardware drivers/cameras");
  EXPECT_EQ(go[2].wait_ms, 500);
  EXPECT_EQ(go[3].kind, Kind::kRestart);
  EXPECT_EQ(go[3].wait_for, WaitFor::kNothing);
  EXPECT_EQ(go[4].kind, Kind::kWaitStatus);
  EXPECT_EQ(go[5].script, "end");
  EXPECT_EQ(config.scripts[1].actions[0].target.kind, TargetKind::kEverything);
}

TEST(LabConfig, ReadsWhatTheOriginalReads) {
  const LabConfig config = parse_lab_config(
      "cmd \"a\" { deputy = \"m\"; exec = \"say \\\"x\\\" \\q\\\\ \\t.\"; auto_respawn = Yes; }\n"
      "cmd 'b' { deputy = \"m\"; exec = \"x\"; auto_respawn = \"NO\"; }\n",
      "lab.cfg");
  EXPECT_EQ(config.commands.at(0).spec.exec, "say \"x\" q\\ \t.");
  EXPECT_TRUE(config.commands.at(0).spec.auto_respawn);
  EXPECT_FALSE(config.commands.at(1).spec.auto_respawn);
}

TEST(LabConfig, WritesWhatItReads) {
  const LabConfig config = example();
  const std::string text = to_text(config);
  const LabConfig again = parse_lab_config(text, "again");
  EXPECT_EQ(to_text(again), text);
  ASSERT_EQ(again.commands.size(), config.commands.size());
  for (std::size_t i = 0; i < config.commands.size(); ++i) {
    EXPECT_EQ(again.commands[i].spec, config.commands[i].spec);
    EXPECT_EQ(again.commands[i].deputy, config.commands[i].deputy);
  }
}

// Its parser takes integers only, and the groups around a command in place of an attribute `group`.
TEST(LabConfig, WritesWhatTheOriginalReads) {
  const std::string command = "cmd \"c\" { exec = \"x\"; deputy = \"d\"; ";
  EXPECT_EQ(to_text(parse_lab_config(command + "group = \"a/b\"; }", "lab.cfg")),
            "group \"a\" {\ngroup \"b\" {\ncmd \"c\" {\n  exec = \"x\";\n  deputy = \"d\";\n"
            "  stop_signal = 2;\n  stop_time_allowed = 7;\n}\n}\n}\n");
  EXPECT_THAT(to_text(parse_lab_config(command + "stop_time_allowed = 0.25; }", "lab.cfg")),
              HasSubstr("stop_time_allowed = 0.250;"))
      << "ours alone reads it";
}

// `host` is what its older files say; quotes within quotes, and variables before the program.
TEST(LabConfig, ReadsAnOlderFileOfTheOriginal) {
  const LabConfig config = parse_lab_config(
      "group \"quotes\" {\n  cmd \"q\" {\n"
      "    exec = \"A=b sh -c 'echo [$0] \\\"$1\\\"' x \\\"y z\\\"\";\n    host = \"here\";\n  "
      "}\n}\n"
      "script \"all\" {\n  start cmd \"q\" wait \"running\";\n}\n",
      "old.cfg");
  ASSERT_EQ(config.commands.size(), 1U);
  EXPECT_EQ(config.commands[0].spec.exec, "A=b sh -c 'echo [$0] \"$1\"' x \"y z\"");
  EXPECT_EQ(config.commands[0].deputy, "here");
  EXPECT_EQ(config.commands[0].spec.group, "quotes");
}

TEST(LabConfig, SelectsCommandsAndNestedGroups) {
  const LabConfig config = example();
  EXPECT_THAT(select(config, {TargetKind::kGroup, "hardware drivers"}), ElementsAre(1U, 2U));
  EXPECT_THAT(select(config, {TargetKind::kGroup, "hardware drivers/cameras"}), ElementsAre(2U));
  EXPECT_THAT(select(config, {TargetKind::kGroup, "hardware"}), ElementsAre());
  EXPECT_THAT(select(config, {TargetKind::kCommand, "interface"}), ElementsAre(1U));
  EXPECT_THAT(select(config, {TargetKind::kEverything, ""}), ElementsAre(0U, 1U, 2U));
}

TEST(LabConfig, SaysWhereAndWhatIsWrong) {
  EXPECT_THAT(problem("cmd \"a\" {\n  exec = \"x\"\n}"),
              HasSubstr("lab.cfg:3:1: expected `;`, found `}`"));
  EXPECT_THAT(problem("cmd \"a\" { deputy = \"d\"; }"), HasSubstr("lacks `exec"));
  EXPECT_THAT(problem("cmd \"a\" { exec = \"x\"; }"), HasSubstr("lacks `deputy"));
  EXPECT_THAT(problem("cmd \"a\" { nice = 3; }"), HasSubstr("no attribute `nice`"));
  EXPECT_THAT(problem("cmd \"a\" { stop_signal = 99; }"), HasSubstr("from 1 to 64"));
  EXPECT_THAT(problem("cmd \"a\" { stop_time_allowed = nan; }"), HasSubstr("expected"));
  EXPECT_THAT(problem("cmd \"a"), HasSubstr("closing quote"));
  EXPECT_THAT(problem("group \"a/b\" { }"), HasSubstr("`/`"));
  EXPECT_THAT(problem("group \"a\" { script \"s\" { } }"), HasSubstr("expected"));
  EXPECT_THAT(problem("script \"s\" { start cmd \"none\"; }"), HasSubstr("no command \"none\""));
  EXPECT_THAT(problem("script \"s\" { run_script \"none\"; }"), HasSubstr("no script \"none\""));
  EXPECT_THAT(problem("script \"s\" { run_script \"t\"; } script \"t\" { run_script \"s\"; }"),
              HasSubstr("run itself"));
  EXPECT_THAT(problem("@"), HasSubstr("no meaning"));
  const std::string command = "cmd \"a\" { exec = \"x\"; deputy = \"d\"; }";
  EXPECT_THAT(problem(command + command), HasSubstr("second command is called \"a\""));
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "group \"g\" {";
  EXPECT_THAT(problem(deep), HasSubstr("nested deeper"));
}

TEST(LabConfig, NoTextMakesItFail) {
  std::ifstream file(FS_SOURCE_DIR "/tests/libs/procman/example.cfg");
  const std::string good((std::istreambuf_iterator<char>(file)), {});
  for (std::size_t length = 0; length < good.size(); ++length) problem(good.substr(0, length));
  std::mt19937 rng(1);
  for (int i = 0; i < 2000; ++i) {
    std::string text = good;
    for (int k = 0; k < 5; ++k) text[rng() % text.size()] = static_cast<char>(rng());
    problem(text);
  }
}

TEST(LabConfig, NamesAFileThatIsMissing) {
  EXPECT_THROW(
      {
        try {
          load_lab_config("/nowhere/lab.cfg");
        } catch (const LabConfigError& error) {
          EXPECT_THAT(error.what(), HasSubstr("/nowhere/lab.cfg"));
          throw;
        }
      },
      LabConfigError);
}

TEST(LabConfig, TheDeploymentsOfTheProjectAreGood) {
  int n = 0;
  for (const auto& entry : std::filesystem::directory_iterator(FS_SOURCE_DIR "/config/labs")) {
    const LabConfig config = load_lab_config(entry.path());
    EXPECT_FALSE(config.commands.empty()) << entry.path();
    EXPECT_NE(find_script(config, "start"), nullptr) << entry.path();
    ++n;
  }
  EXPECT_GE(n, 3);
}

}  // namespace
}  // namespace fusion_slam
