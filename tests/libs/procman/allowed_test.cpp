#include "libs/procman/allowed.hpp"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class AllowedTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(root_);
    for (const char* const name : {"opt/robot/bin/drive", "opt/robotics/evil", "bin/sh"}) {
      fs::create_directories((root_ / name).parent_path());
      std::ofstream(root_ / name) << "#!/bin/sh\n";
      fs::permissions(root_ / name, fs::perms::owner_all);
    }
    fs::create_symlink(root_ / "bin/sh", root_ / "opt/robot/bin/shell");
    allowed_.folders = {root_ / "opt/robot"};
  }
  void TearDown() override { fs::remove_all(root_); }

  fs::path find(const std::string& exec) {
    const auto line = parse_exec_line(
        exec, [](const auto&) { return std::nullopt; }, &why_);
    return line ? find_allowed(allowed_, *line,
                               (root_ / "bin").string() + ":" + (root_ / "opt/robot/bin").string(),
                               &why_)
                : fs::path();
  }

  fs::path root_ = fs::canonical(testing::TempDir()) / "allowed_test";
  Allowed allowed_;
  std::string why_;
};

TEST_F(AllowedTest, ProgramsBelowTheFolders) {
  EXPECT_EQ(find((root_ / "opt/robot/bin/drive").string()), root_ / "opt/robot/bin/drive");
  EXPECT_EQ(find("drive --fast"), root_ / "opt/robot/bin/drive") << "by the search path";
}

TEST_F(AllowedTest, NothingElseByWhateverWay) {
  for (const std::string& exec :
       {(root_ / "opt/robotics/evil").string(), (root_ / "bin/sh").string(), std::string("sh"),
        (root_ / "opt/robot/../robotics/evil").string(), (root_ / "opt/robot/bin/shell").string(),
        std::string("shell")}) {
    EXPECT_EQ(find(exec), fs::path()) << exec;
    EXPECT_THAT(why_, HasSubstr("is not below a folder")) << exec;
  }
  EXPECT_EQ(find("none"), fs::path());
  EXPECT_THAT(why_, HasSubstr("no program none"));
}

TEST_F(AllowedTest, VariablesThatWouldMakeAProgramRunAnythingAreRefused) {
  EXPECT_EQ(find("LD_PRELOAD=/tmp/evil.so drive"), fs::path());
  EXPECT_THAT(why_, HasSubstr("LD_PRELOAD"));
  EXPECT_EQ(find("PATH=/tmp drive"), fs::path());
  EXPECT_NE(find("LCM_DEFAULT_URL=x FUSION_SLAM_LOG=y TZ=UTC drive"), fs::path());
  allowed_.variables = {"DISPLAY"};
  EXPECT_NE(find("DISPLAY=:0 drive"), fs::path());
}

TEST_F(AllowedTest, OneProgramMayBeNamed) {
  allowed_.folders = {root_ / "bin/sh"};
  EXPECT_NE(find("sh"), fs::path());
  EXPECT_EQ(find("drive"), fs::path());
}

TEST_F(AllowedTest, OrAnything) {
  allowed_.anything = true;
  EXPECT_NE(find("LD_PRELOAD=x sh"), fs::path());
  EXPECT_EQ(find("none"), fs::path());
}

}  // namespace
}  // namespace fusion_slam
