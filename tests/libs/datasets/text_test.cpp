#include "libs/datasets/text.hpp"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include "libs/datasets/trajectory_file.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

TEST(Text, SecondsKeepEveryMicrosecond) {
  EXPECT_EQ(parse_seconds_us("1305031453.359684"), 1305031453359684);
  EXPECT_EQ(parse_seconds_us("0.227623"), 227623);
  EXPECT_EQ(parse_seconds_us("12"), 12000000);
  EXPECT_EQ(parse_seconds_us("1.5"), 1500000);
  EXPECT_EQ(parse_seconds_us("-0.042"), -42000);
  EXPECT_EQ(parse_seconds_us("1.13486e+09"), 1134860000000000);
  EXPECT_EQ(parse_seconds_us("1.1234567"), 1123457);  // a seventh digit is rounded
  for (const char* bad : {"", "x", "1e300", "nan", "1.2.3", "9999999999999999", "--1"})
    EXPECT_FALSE(parse_seconds_us(bad)) << bad;
}

TEST(Text, NumbersMustBeWholeWordsAndFinite) {
  EXPECT_EQ(parse_number("-1.5e2"), -150.0);
  EXPECT_EQ(parse_number("+2"), 2.0);
  for (const char* bad : {"", "1,5", "1x", "inf", "nan", "0x10"})
    EXPECT_FALSE(parse_number(bad)) << bad;
}

TEST(Text, LinesAndWords) {
  std::string_view text = "a  b\r\n\nc";
  std::string_view line;
  ASSERT_TRUE(next_line(&text, &line));
  EXPECT_EQ(next_word(&line), "a");
  EXPECT_EQ(next_word(&line), "b");
  EXPECT_EQ(next_word(&line), "");
  ASSERT_TRUE(next_line(&text, &line));
  EXPECT_EQ(line, "");
  ASSERT_TRUE(next_line(&text, &line));
  EXPECT_EQ(line, "c");
  EXPECT_FALSE(next_line(&text, &line));
}

TEST(Text, FilesThatCannotBeUsedAreNamed) {
  const fs::path dir = fs::temp_directory_path() / ("fs_text_test_" + std::to_string(getpid()));
  fs::create_directories(dir);
  const auto error = [](const fs::path& path) -> std::string {
    try {
      read_text_file(path);
    } catch (const DatasetError& e) {
      return e.what();
    }
    return "no error";
  };
  std::ofstream(dir / "empty");
  const std::string text(100000, 'q');
  gzFile gz = gzopen((dir / "whole.gz").c_str(), "wb");
  gzwrite(gz, text.data(), static_cast<unsigned>(text.size()));
  gzclose(gz);
  EXPECT_EQ(read_text_file(dir / "whole.gz"), text);
  fs::copy(dir / "whole.gz", dir / "cut.gz");
  fs::resize_file(dir / "cut.gz", fs::file_size(dir / "cut.gz") / 2);
  EXPECT_THAT(error(dir / "cut.gz"), testing::HasSubstr("end early"));
  EXPECT_THAT(error(dir / "empty"), testing::HasSubstr("is empty"));
  EXPECT_THAT(error(dir), testing::HasSubstr("is a directory"));
  EXPECT_THAT(error(dir / "none"), testing::HasSubstr("cannot be opened"));
  fs::remove_all(dir);
}

TEST(TumTrajectory, GoldenLinesAndDamage) {
  const auto t = parse_tum_trajectory(
      "# comment\n1.5 1 2 3 0 0 0.70710678 0.70710678\n"
      "1.5 1 2 3 0 0 0 1\n2.0 1 2 3 0 0 0\n2.5 1 2 3 0 0 0 0\n3.0 4 5 6 0 0 0 1\n");
  ASSERT_EQ(t.poses.size(), 2u);
  EXPECT_EQ(t.poses[0].utime_us, 1500000);
  EXPECT_TRUE((t.poses[0].T_world_reference * Eigen::Vector3d(1, 0, 0))
                  .isApprox(Eigen::Vector3d(1, 3, 3), 1e-6));
  EXPECT_EQ(t.skipped.total(), 3);
  EXPECT_EQ(t.skipped.reasons().at("time stamp does not increase").first_place, 3);
  EXPECT_EQ(t.skipped.reasons().at("fewer than 8 numbers").first_place, 4);
  EXPECT_EQ(t.skipped.reasons().at("quaternion is not a rotation").first_place, 5);
}

}  // namespace
}  // namespace fusion_slam
