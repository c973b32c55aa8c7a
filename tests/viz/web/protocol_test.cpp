#include "viz/web/protocol.hpp"

#include <fstream>
#include <iterator>
#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

std::string hex(const std::string& bytes) {
  static const char* const kDigits = "0123456789abcdef";
  std::string out;
  for (const char byte : bytes) {
    out += kDigits[static_cast<unsigned char>(byte) >> 4];
    out += kDigits[static_cast<unsigned char>(byte) & 15];
  }
  return out;
}

// The hex digits of a golden file; words after # are for people.
std::string golden(const std::string& name) {
  std::ifstream file(std::string(FS_SOURCE_DIR) + "/tests/viz/web/golden/" + name);
  std::string digits;
  for (std::string line; std::getline(file, line);)
    for (const char c : line.substr(0, line.find('#')))
      if (c != ' ') digits += c;
  return digits;
}

Item item(Topic topic, const std::string& key, const char* payload) {
  return {topic, key, payload == nullptr ? nullptr : std::make_shared<const std::string>(payload)};
}

TEST(Protocol, ABatchIsTheGoldenFile) {
  const std::string bytes = encode_batch(
      7, 0x01020304, {item(Topic::kPose, "", "{}"), item(Topic::kCloud, "1,-2,0", nullptr)});
  EXPECT_EQ(hex(bytes), golden("batch.hex"));
}

TEST(Protocol, ATileIsTheGoldenFile) {
  Tile tile;
  tile.key = {0, 1, -2, 3};
  tile.utime_us = 1'700'000'000'000'000;
  tile.resolution_m = 0.05;
  tile.size_cells = 64;
  tile.encoding = TileEncoding::kGridFused;
  tile.data = {0xde, 0xad};
  EXPECT_EQ(hex(encode_tile(tile)), golden("tile.hex"));
}

TEST(Protocol, APoseIsPositionThenQuaternion) {
  const SE3 T = make_pose({1.0, 2.0, -0.5}, 1.0, 0.0, 0.0, 0.0);
  EXPECT_EQ(hex(ByteWriter().pose(T).take()), golden("pose.hex"));
}

TEST(Protocol, NamesOfTopicsAreTheirInverse) {
  for (std::size_t i = 0; i < kTopics; ++i)
    EXPECT_EQ(topic_from(name_of(static_cast<Topic>(i))), static_cast<Topic>(i));
  EXPECT_FALSE(topic_from("nonsense"));
}

TEST(ParseRequest, EachKind) {
  std::string why;
  auto request = parse_request(R"({"type":"ack","batch":4294967295})", &why);
  ASSERT_TRUE(request) << why;
  EXPECT_EQ(request->batch, 4294967295U);
  request = parse_request(R"({"type":"want","topics":["pose","cloud"]})", &why);
  ASSERT_TRUE(request) << why;
  EXPECT_EQ(request->topics.count(), 2U);
  EXPECT_TRUE(request->topics[static_cast<std::size_t>(Topic::kCloud)]);
  request = parse_request(R"({"type":"cell","id":3,"x":1.5,"y":-2})", &why);
  ASSERT_TRUE(request) << why;
  EXPECT_EQ(request->kind, Request::Kind::kCell);
  EXPECT_DOUBLE_EQ(request->y_m, -2.0);
  request =
      parse_request(R"({"type":"command","id":4,"verb":"localise","x":1,"y":2,"yaw":-3.1})", &why);
  ASSERT_TRUE(request) << why;
  EXPECT_DOUBLE_EQ(request->yaw_rad, -3.1);
  request = parse_request(R"({"type":"command","id":5,"verb":"stop","target":"fuser"})", &why);
  ASSERT_TRUE(request) << why;
  EXPECT_EQ(request->target, "fuser");
  request = parse_request(R"({"type":"replay","id":6,"verb":"seek","value":12.5})", &why);
  ASSERT_TRUE(request) << why;
  EXPECT_DOUBLE_EQ(request->value, 12.5);
}

TEST(ParseRequest, RefusesWithAReason) {
  const std::vector<std::string> bad = {
      "",
      "null",
      "[]",
      "{",
      "{}",
      "42",
      R"({"type":"quit"})",
      R"({"type":7})",
      R"({"type":"ack"})",
      R"({"type":"ack","batch":-1})",
      R"({"type":"ack","batch":1e300})",
      R"({"type":"want"})",
      R"({"type":"want","topics":"pose"})",
      R"({"type":"want","topics":["passwords"]})",
      R"({"type":"want","topics":[[[[]]]]})",
      R"({"type":"cell","id":1,"x":1})",
      R"({"type":"cell","id":1,"x":"1","y":2})",
      R"({"type":"cell","id":1,"x":1e9,"y":2})",
      R"({"type":"cell","x":1,"y":2})",
      R"({"type":"command","id":1,"verb":"quit"})",
      R"({"type":"command","id":1,"verb":"localise","x":1,"y":2})",
      R"({"type":"command","id":1,"verb":"localise","x":1,"y":2,"yaw":100})",
      R"({"type":"command","id":1,"verb":"start"})",
      R"({"type":"command","id":1,"verb":"start","target":""})",
      R"({"type":"command","id":1,"verb":"start","target":"--key"})",
      R"({"type":"command","id":1,"verb":"start","target":")" + std::string(201, 'a') + "\"}",
      R"({"type":"replay","id":1,"verb":"speed","value":0})",
      R"({"type":"replay","id":1,"verb":"speed","value":-5})",
      R"({"type":"replay","id":1,"verb":"seek"})",
      "{\"type\":\"\xff\xfe\"}",
      std::string(kMaxRequestBytes + 1, ' '),
      std::string(4000, '[')};
  for (const std::string& text : bad) {
    std::string why;
    EXPECT_FALSE(parse_request(text, &why)) << text;
    EXPECT_FALSE(why.empty()) << text;
  }
}

// The fuzzer (tests/fuzz/viewer_request_fuzz.cpp) goes further; this runs everywhere.
TEST(ParseRequest, DamagedRequestsNeverThrow) {
  const std::string good = R"({"type":"command","id":4,"verb":"localise","x":1,"y":2,"yaw":-3.1})";
  std::mt19937 random(5);
  for (int i = 0; i < 5000; ++i) {
    std::string text = good.substr(0, random() % (good.size() + 1));
    for (unsigned k = random() % 4; k > 0 && !text.empty(); --k)
      text[random() % text.size()] = static_cast<char>(random() % 256);
    std::string why;
    EXPECT_NO_THROW(parse_request(text, &why));
  }
}

}  // namespace
}  // namespace fusion_slam
