#include "libs/procman/exec_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

using testing::ElementsAre;
using testing::Pair;

std::optional<std::string> environment(const std::string& name) {
  if (name == "HOME") return "/home/lab robot";
  return std::nullopt;
}

std::vector<std::string> argv(const std::string& text) {
  std::string why;
  const auto line = parse_exec_line(text, environment, &why);
  return line ? line->argv : std::vector<std::string>{"PROBLEM: " + why};
}

TEST(ExecLine, SplitsAsAShellDoes) {
  EXPECT_THAT(argv("  ls  -l\t/tmp "), ElementsAre("ls", "-l", "/tmp"));
  EXPECT_THAT(argv("bash -c 'echo arg0: [$0]' abc \"def ghi\" 'jkl mno'"),
              ElementsAre("bash", "-c", "echo arg0: [$0]", "abc", "def ghi", "jkl mno"));
  EXPECT_THAT(argv(R"(a\ b "c\"d" 'e\f' g"h"'i')"), ElementsAre("a b", "c\"d", "e\\f", "ghi"));
  EXPECT_THAT(argv("x ''"), ElementsAre("x", ""));
}

TEST(ExecLine, PutsVariablesIn) {
  EXPECT_THAT(argv("ls $HOME ${HOME}s \"$HOME/x\" '$HOME' \\$HOME $NOTHING- $ $1"),
              ElementsAre("ls", "/home/lab robot", "/home/lab robots", "/home/lab robot/x", "$HOME",
                          "$HOME", "$NOTHING-", "$", "$1"));
}

TEST(ExecLine, LeavesToAShellWhatIsItsOwn) {
  EXPECT_THAT(argv("sh -c \"echo ${NOTHING} ${HOME:-x} ${ $$ ${HOME\""),
              ElementsAre("sh", "-c", "echo ${NOTHING} ${HOME:-x} ${ $$ ${HOME"));
}

TEST(ExecLine, TakesAssignmentsOffTheFront) {
  const auto line =
      parse_exec_line("ABC=def GHI=\"jkl mno\" U=$ABC bash X=1 $GHI", environment, nullptr);
  ASSERT_TRUE(line);
  EXPECT_THAT(line->environment,
              ElementsAre(Pair("ABC", "def"), Pair("GHI", "jkl mno"), Pair("U", "def")));
  EXPECT_THAT(line->argv, ElementsAre("bash", "X=1", "jkl mno"));
  EXPECT_THAT(argv("1A=b"), ElementsAre("1A=b"));
  EXPECT_THAT(argv("\"A\"=b"), ElementsAre("A=b")) << "quoted: a program";
}

TEST(ExecLine, SaysWhatIsWrong) {
  EXPECT_THAT(argv(""), ElementsAre("PROBLEM: it names no program"));
  EXPECT_THAT(argv("A=b"), ElementsAre("PROBLEM: it names no program"));
  EXPECT_THAT(argv("a 'b"), ElementsAre("PROBLEM: a ' is not closed"));
  EXPECT_THAT(argv("a \"b"), ElementsAre("PROBLEM: a \" is not closed"));
}

}  // namespace
}  // namespace fusion_slam
