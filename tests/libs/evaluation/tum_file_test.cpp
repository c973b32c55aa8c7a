#include "libs/evaluation/tum_file.hpp"

#include <fstream>
#include <sstream>

#include <gmock/gmock.h>

namespace fusion_slam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TumFile read(const std::string& text) {
  std::istringstream in(text);
  return read_tum(in, "walk.tum");
}

std::string problem_of(const std::string& text) {
  try {
    read(text);
  } catch (const FileError& error) {
    return error.what();
  }
  return "(no error)";
}

std::string contents(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

Trajectory walk() {
  Trajectory trajectory;
  const SE3 T_yaw = make_pose({1.0, -2.5, 1e-12}, std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5));
  const SE3 T_back = make_pose({-1e-12, 0.000000001, 123.456789123}, -0.5, 0.5, 0.5, 0.5);
  trajectory.push_back({1305031102.160407, T_yaw});
  trajectory.push_back({1305031102.19433, T_back});
  return trajectory;
}

TEST(TumFile, WritesTheGoldenFile) {
  const std::string golden =
      contents(std::string(FS_SOURCE_DIR) + "/tests/libs/evaluation/golden.tum");
  ASSERT_FALSE(golden.empty());
  std::ostringstream out;
  write_tum(out, walk(), "timestamp tx ty tz qx qy qz qw");
  EXPECT_EQ(out.str(), golden);
}

TEST(TumFile, ReadsTheGoldenFileBack) {
  const auto file = std::filesystem::path(FS_SOURCE_DIR) / "tests/libs/evaluation/golden.tum";
  const TumFile read_back = read_tum(file);
  const Trajectory expected = walk();
  ASSERT_EQ(read_back.trajectory.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(read_back.trajectory[i].time_s, expected[i].time_s);
    EXPECT_TRUE(read_back.trajectory[i].T_world_body.isApprox(expected[i].T_world_body, 1e-9));
  }
}

TEST(TumFile, WritesThroughARenameAndSurvivesUtimes) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("tum_file_test_" + std::to_string(::getpid()) + ".tum");
  Trajectory trajectory;
  for (int i = 0; i < 1000; ++i) {
    const long long utime = 1305031102160407LL + 33333LL * i;
    trajectory.push_back({static_cast<double>(utime) * 1e-6, SE3::Identity()});
  }
  write_tum(file, trajectory);
  EXPECT_FALSE(std::filesystem::exists(file.string() + ".part"));
  const TumFile back = read_tum(file);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(std::llround(back.trajectory[i].time_s * 1e6), 1305031102160407LL + 33333LL * i);
  }
  std::filesystem::remove(file);
}

TEST(TumFile, ToleratesCommentsBlankLinesTabsAndCarriageReturns) {
  const TumFile file =
      read("# a comment\r\n\n   # indented\n1 0 0 0 0 0 0 1\r\n\t2\t1 2 +3 0 0 0 -1  \n");
  ASSERT_EQ(file.trajectory.size(), 2u);
  EXPECT_EQ(file.trajectory[1].time_s, 2.0);
  EXPECT_EQ(file.trajectory[1].T_world_body.translation(), Eigen::Vector3d(1, 2, 3));
}

TEST(TumFile, ReadsWithoutALastNewline) {
  EXPECT_EQ(read("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1").trajectory.size(), 2u);
}

TEST(TumFile, OrdersByTimeAndCounts) {
  const TumFile file = read(
      "2 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n3 2 0 0 0 0 0 1\n3 3 0 0 0 0 0 1\n2.5 4 0 0 0 0 0 1\n");
  std::vector<double> x;
  for (const StampedPose& pose : file.trajectory) x.push_back(pose.T_world_body.translation().x());
  EXPECT_THAT(x, ::testing::ElementsAre(1, 0, 4, 2, 3));
  EXPECT_EQ(file.out_of_order, 2u);
  EXPECT_EQ(file.repeated, 1u);
}

TEST(TumFile, NamesFileLineAndReason) {
  EXPECT_THAT(problem_of("# c\n1 0 0 0 0 0 0 1\n2 0 0 0 0 0 1\n"),
              AllOf(HasSubstr("walk.tum:3: "), HasSubstr("found 7 fields")));
  EXPECT_THAT(problem_of("1 0 0 0 0 0 0 1 9\n"), HasSubstr("found 9 fields"));
  EXPECT_THAT(problem_of("1,0,0,0,0,0,0,1\n"), HasSubstr("found 1 field: '1,0,0,0,0,0,0,1'"));
  EXPECT_THAT(problem_of("1 0 zero 0 0 0 0 1\n"),
              AllOf(HasSubstr("walk.tum:1: field 3 of"), HasSubstr("'zero'")));
  EXPECT_THAT(problem_of("1 0 0 nan 0 0 0 1\n"), HasSubstr("not a finite number"));
  EXPECT_THAT(problem_of("1 0 0 inf 0 0 0 1\n"), HasSubstr("not a finite number"));
  EXPECT_THAT(problem_of("1 0 0 1e999 0 0 0 1\n"), HasSubstr("not a finite number"));
  EXPECT_THAT(problem_of("1 0 0 0 0 0 0 0\n"), HasSubstr("has norm 0, not 1"));
  EXPECT_THAT(problem_of("1 0 0 0 0.7 0.7 0.7 0.7\n"), HasSubstr("are these TUM columns?"));
  EXPECT_THAT(problem_of("1 0 0 0 \x01\xff 0 0 1\n"), HasSubstr("'?\?'"));
}

TEST(TumFile, RefusesFilesWithoutPoses) {
  EXPECT_THAT(problem_of(""), HasSubstr("walk.tum: no line of numbers"));
  EXPECT_THAT(problem_of("# only\n\n"), HasSubstr("no line of numbers"));
  EXPECT_THROW(read_tum(std::filesystem::path("/nowhere/at/all.tum")), FileError);
  EXPECT_THROW(read_tum(std::filesystem::path("/tmp")), FileError);
}

TEST(TumFile, SaysWhenItCannotWrite) {
  EXPECT_THROW(write_tum(std::filesystem::path("/nowhere/at/all.tum"), walk()), FileError);
}

TEST(TumFile, HugeNumbersAreNotCut) {
  std::stringstream file;
  write_tum(file, {{1.0, make_pose({1e300, -1e60, 0.0}, 1.0, 0.0, 0.0, 0.0)}}, "");
  const TumFile back = read_tum(file, "huge");
  ASSERT_EQ(back.trajectory.size(), 1U);
  EXPECT_EQ(back.trajectory[0].T_world_body.translation(), Eigen::Vector3d(1e300, -1e60, 0.0));
}

}  // namespace
}  // namespace fusion_slam
