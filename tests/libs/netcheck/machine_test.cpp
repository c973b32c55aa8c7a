#include "libs/netcheck/machine.hpp"

#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "procman/doctor/report.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

TEST(Machine, finds_programs_on_the_path) {
  EXPECT_FALSE(find_program("sh").empty());
  EXPECT_TRUE(find_program("no-such-program").empty());
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  const std::vector<CheckResult> results = check_programs();
  setenv("PATH", path.c_str(), 1);
  ASSERT_EQ(results.size(), 5U);
  EXPECT_EQ(results[0].name, "lcm-logger");
  EXPECT_EQ(results[0].state, CheckState::kFault);
  EXPECT_EQ(results[0].command, "apt-get install --yes liblcm-bin");
  EXPECT_EQ(results[3].state, CheckState::kWarning);
}

TEST(Machine, knows_the_date_and_the_disk) {
  EXPECT_NE(check_clock().state, CheckState::kFault);
  EXPECT_THAT(check_disk("/").found, HasSubstr("GB free in /"));
  const CheckResult missing = check_disk("/no/such/folder");
  EXPECT_EQ(missing.state, CheckState::kFault);
  EXPECT_EQ(missing.command, "mkdir -p /no/such/folder");
}

TEST(Report, shows_each_check_and_what_mends_it) {
  const std::vector<CheckResult> results = {{"route", CheckState::kGood, "fine", ""},
                                            {"clock", CheckState::kWarning, "slow", "tick"},
                                            {"disk", CheckState::kFault, "full", "rm x"}};
  EXPECT_EQ(text_report(results),
            "good     route           fine\n"
            "warning  clock           slow\n"
            "         mend it with:   tick\n"
            "FAULT    disk            full\n"
            "         mend it with:   rm x\n"
            "1 faults; commands that change the system need root (sudo), and those of `sysctl -w` "
            "and `ip` last until the "
            "next boot\n");
  EXPECT_EQ(commands(results), "rm x\n");
  EXPECT_TRUE(has_fault(results));
  EXPECT_FALSE(has_fault({results[0], results[1]}));
}

}  // namespace
}  // namespace fusion_slam
