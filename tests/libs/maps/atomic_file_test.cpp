#include "libs/maps/atomic_file.hpp"

#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/libs/maps/test_files.hpp"

namespace fusion_slam {
namespace {

TEST(AtomicFile, ReplacesAndLeavesNoPartialFile) {
  const auto directory = scratch();
  write_file_atomically(directory / "a", "old");
  write_file_atomically(directory / "a", std::string("new\0er", 6));
  EXPECT_EQ(read_bytes(directory / "a"), std::string("new\0er", 6));
  EXPECT_FALSE(std::filesystem::exists(directory / "a.partial"));
}

TEST(AtomicFile, SaysWhatWentWrongAndKeepsWhatWasThere) {
  const auto directory = scratch();
  std::filesystem::create_directories(directory / "a" / "not_empty");  // can't be renamed over
  try {
    write_file_atomically(directory / "a", "x");
    FAIL() << "no exception";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find((directory / "a").string()), std::string::npos);
  }
  EXPECT_FALSE(std::filesystem::exists(directory / "a.partial"));
  EXPECT_THROW(write_file_atomically(directory / "no" / "where", "x"), std::runtime_error);
}

}  // namespace
}  // namespace fusion_slam
