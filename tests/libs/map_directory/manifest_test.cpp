#include "libs/map_directory/manifest.hpp"

#include "tests/libs/map_directory/session_log.hpp"

namespace fusion_slam {
namespace {

Manifest example() {
  Manifest manifest;
  manifest.summary.robot = "a \"robot\"";
  manifest.summary.has_lidar = true;
  manifest.summary.resolution_m = 0.05;
  manifest.summary.keyframes = 3;
  manifest.summary.last_utime_us = kSessionUs;
  manifest.files[kJournalName] = {123, 0xDEADBEEF};
  manifest.files["map.pgm"] = {7, 1};
  return manifest;
}

std::string error_of_text(const std::string& text) {
  return error_of([&] { parse_manifest(text, "/maps/here"); });
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), with);
}

TEST(Manifest, RoundTrip) {
  const Manifest manifest = example();
  const Manifest again = parse_manifest(to_json(manifest), "d");
  EXPECT_EQ(to_json(again), to_json(manifest));
  EXPECT_EQ(again.summary.robot, manifest.summary.robot);
  EXPECT_EQ(again.files.at(kJournalName).crc32, 0xDEADBEEF);
  EXPECT_EQ(again.files.at(kJournalName).size_bytes, 123);
}

TEST(Manifest, SaysWhatIsWrong) {
  const std::string good = to_json(example());
  EXPECT_NE(error_of_text(good.substr(0, good.size() / 2)).find("not valid JSON"),
            std::string::npos);
  EXPECT_NE(error_of_text("{}").find("not the manifest of a Fusion-SLAM map"), std::string::npos);
  EXPECT_NE(error_of_text("[1]").find("not the manifest"), std::string::npos);
  const std::string newer = error_of_text(replaced(good, "\"format\": 1", "\"format\": 2"));
  EXPECT_NE(newer.find("/maps/here: is a map of format 2; this program knows up to 1"),
            std::string::npos)
      << newer;
  EXPECT_NE(error_of_text(replaced(good, "\"robot\"", "\"rabbit\"")).find("robot"),
            std::string::npos);
  EXPECT_NE(error_of_text(replaced(good, "deadbeef", "no number")).find("checksum"),
            std::string::npos);
  EXPECT_NE(error_of_text(replaced(good, "map.pgm", "../map.pgm")).find("no name of a file"),
            std::string::npos);
  EXPECT_NE(error_of_text(replaced(good, kJournalName, "other")).find("names no journal"),
            std::string::npos);
}

TEST(Manifest, MeasuresFiles) {
  const auto file = scratch() / "f";
  std::ofstream(file) << "123456789";
  EXPECT_EQ(measure_file(file).size_bytes, 9);
  EXPECT_EQ(measure_file(file).crc32, 0xCBF43926U);  // the check value of CRC-32
  EXPECT_NE(error_of([&] { measure_file(file.string() + "x"); }).find("can't be read"),
            std::string::npos);
}

}  // namespace
}  // namespace fusion_slam
