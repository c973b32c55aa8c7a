#include "libs/map_directory/map_reader.hpp"

#include "tests/libs/map_directory/session_log.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

class MapReaderTest : public testing::Test {
 protected:
  MapReaderTest() {
    save_session(write_session(place_ / "run"), map_, {});
    before_ = contents(map_);
  }
  std::string error() const {
    return error_of([&] { read_state(MapReader(map_)); });
  }
  void expect_error(const std::string& text) const {
    const std::string said = error();
    EXPECT_NE(said.find(text), std::string::npos) << said;
    EXPECT_NE(said.find(map_.string()), std::string::npos) << "does not name the map: " << said;
  }
  void write(const std::string& name, const std::string& bytes) {
    std::ofstream(map_ / name, std::ios::binary | std::ios::trunc) << bytes;
    before_[name] = bytes;
  }

  fs::path place_ = scratch();
  fs::path map_ = place_ / "map";
  std::map<std::string, std::string> before_;
};

TEST_F(MapReaderTest, ReadingChangesNothing) {
  EXPECT_EQ(error(), "no error");
  EXPECT_EQ(contents(map_), before_);
}

TEST_F(MapReaderTest, CutOffAnywhere) {
  const std::string journal = before_.at(kJournalName);
  for (std::size_t size = 0; size < journal.size(); size += 1 + journal.size() / 7) {
    write(kJournalName, journal.substr(0, size));
    expect_error("it was cut off or changed");
    EXPECT_EQ(contents(map_), before_);  // untouched
  }
}

TEST_F(MapReaderTest, OneBitChanged) {
  std::string journal = before_.at(kJournalName);
  journal[journal.size() / 2] ^= 1;
  write(kJournalName, journal);
  expect_error("checksum is wrong");
}

TEST_F(MapReaderTest, AFileIsMissing) {
  fs::remove(map_ / "map.pgm");
  expect_error("map.pgm: is missing");
}

TEST_F(MapReaderTest, ForeignThings) {
  fs::remove(map_ / kManifestName);
  expect_error("is no Fusion-SLAM map");
  write(kManifestName, "{\"image\": \"map.pgm\"}");
  expect_error("is not the manifest of a Fusion-SLAM map");
  fs::remove_all(map_);
  expect_error("there is no such directory");
  std::ofstream(map_) << "x";
  expect_error("is a file");
}

TEST_F(MapReaderTest, AMapFromTheFuture) {
  std::string manifest = before_.at(kManifestName);
  const auto at = manifest.find("\"format\": 1");
  ASSERT_NE(at, std::string::npos);
  manifest.replace(at, 11, "\"format\": 9");
  write(kManifestName, manifest);
  expect_error("is a map of format 9");
  EXPECT_EQ(contents(map_), before_);
}

}  // namespace
}  // namespace fusion_slam
