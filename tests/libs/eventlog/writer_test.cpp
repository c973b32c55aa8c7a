#include "libs/eventlog/writer.hpp"

#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "libs/eventlog/reader.hpp"
#include "tests/libs/eventlog/files.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

TEST(LogWriter, writes_the_bytes_of_the_format) {
  const TemporaryFolder folder;
  LogWriter writer(folder / "w.lcm");
  writer.write(1'700'000'000'123'456, "POSE", to_bytes("abc"));
  writer.write(-7, "T", {});
  writer.close();
  EXPECT_EQ(read_file(folder / "w.lcm"),
            event_bytes(0, 1'700'000'000'123'456, "POSE", "abc") + event_bytes(1, -7, "T", ""));
  EXPECT_EQ(writer.n_events(), 2);
  EXPECT_EQ(writer.size_bytes(), static_cast<std::int64_t>(read_file(folder / "w.lcm").size()));
}

TEST(LogWriter, shows_the_file_only_when_it_is_whole) {
  const TemporaryFolder folder;
  write_file(folder / "w.lcm", "older");
  {
    LogWriter abandoned(folder / "w.lcm");
    abandoned.write(1, "A", to_bytes("x"));
    EXPECT_TRUE(std::filesystem::exists(folder / "w.lcm.partial"));
  }
  EXPECT_EQ(read_file(folder / "w.lcm"), "older");
  EXPECT_FALSE(std::filesystem::exists(folder / "w.lcm.partial"));
  LogWriter writer(folder / "w.lcm");
  writer.write(1, "A", to_bytes("x"));
  EXPECT_EQ(read_file(folder / "w.lcm"), "older");
  writer.close();
  EXPECT_EQ(read_file(folder / "w.lcm"), event_bytes(0, 1, "A", "x"));
  EXPECT_FALSE(std::filesystem::exists(folder / "w.lcm.partial"));
  writer.close();  // again: nothing
  EXPECT_THROW(writer.write(1, "A", to_bytes("x")), std::logic_error);
}

TEST(LogWriter, refuses_what_lcm_cannot_send) {
  const TemporaryFolder folder;
  LogWriter writer(folder / "w.lcm");
  EXPECT_THROW(writer.write(1, "", {}), std::invalid_argument);
  EXPECT_THROW(writer.write(1, std::string(64, 'A'), {}), std::invalid_argument);
  EXPECT_THROW(LogWriter(folder / "no_such_folder/w.lcm"), std::runtime_error);
}

// A limit on the file's size stands for a full disk: writes fail in the same place.
TEST(LogWriter, leaves_nothing_behind_on_a_full_disk) {
  const TemporaryFolder folder;
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{100'000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::string message;
  try {
    LogWriter writer(folder / "w.lcm");
    for (int i = 0; i < 200; ++i) writer.write(i, "A", std::vector<std::uint8_t>(1000));
    writer.close();
  } catch (const std::runtime_error& error) {
    message = error.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(message, HasSubstr("w.lcm.partial: cannot be written: File too large"));
  EXPECT_FALSE(std::filesystem::exists(folder / "w.lcm"));
  EXPECT_FALSE(std::filesystem::exists(folder / "w.lcm.partial"));
}

}  // namespace
}  // namespace fusion_slam
