#include "libs/map_directory/atomic_directory.hpp"

#include "tests/libs/map_directory/session_log.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

void put(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

std::size_t entries(const fs::path& directory) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(directory), fs::directory_iterator()));
}

TEST(AtomicDirectory, AppearsWhole) {
  const fs::path place = scratch();
  AtomicDirectory directory(place / "deep" / "map/");
  put(directory.path() / "a", "new");
  EXPECT_FALSE(fs::exists(place / "deep/map"));
  directory.commit();
  EXPECT_EQ(read_bytes(place / "deep/map/a"), "new");
  EXPECT_EQ(entries(place / "deep"), 1U);
}

TEST(AtomicDirectory, ReplacesInOneStep) {
  const fs::path place = scratch();
  fs::create_directory(place / "map");
  put(place / "map/a", "old");
  put(place / "map/gone", "old");
  {
    AtomicDirectory directory(place / "map");
    put(directory.path() / "a", "new");
    EXPECT_EQ(read_bytes(place / "map/a"), "old");
    directory.commit();
  }
  EXPECT_EQ(contents(place / "map"), (std::map<std::string, std::string>{{"a", "new"}}));
  EXPECT_EQ(entries(place), 1U);
}

TEST(AtomicDirectory, WithoutCommitNothingChanges) {
  const fs::path place = scratch();
  fs::create_directory(place / "map");
  put(place / "map/a", "old");
  {
    AtomicDirectory directory(place / "map");
    put(directory.path() / "a", "new");
  }
  EXPECT_EQ(read_bytes(place / "map/a"), "old");
  EXPECT_EQ(entries(place), 1U);
}

TEST(AtomicDirectory, ALinkStaysALink) {
  const fs::path place = scratch();
  fs::create_directory(place / "real");
  fs::create_directory_symlink("real", place / "link");
  AtomicDirectory directory(place / "link");
  put(directory.path() / "a", "new");
  directory.commit();
  EXPECT_TRUE(fs::is_symlink(place / "link"));
  EXPECT_EQ(read_bytes(place / "real/a"), "new");
}

TEST(AtomicDirectory, RemovesWhatTheDeadLeft) {
  const fs::path place = scratch();
  fs::create_directory(place / "map.partial-999999999-0");
  fs::create_directory(place / "map.partial-1-0");  // of a process that lives
  fs::create_directory(place / "map.partial-mine");
  AtomicDirectory directory(place / "map");
  EXPECT_FALSE(fs::exists(place / "map.partial-999999999-0"));
  EXPECT_TRUE(fs::exists(place / "map.partial-1-0"));
  EXPECT_TRUE(fs::exists(place / "map.partial-mine"));
}

TEST(AtomicDirectory, SaysWhereItCantBe) {
  const fs::path place = scratch();
  put(place / "file", "");
  const std::string error = error_of([&] { AtomicDirectory(place / "file" / "map"); });
  EXPECT_NE(error.find("file"), std::string::npos) << error;
  EXPECT_NE(error.find("choose another place"), std::string::npos) << error;
}

}  // namespace
}  // namespace fusion_slam
