#include "libs/config/yaml_map.hpp"

#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

using testing::HasSubstr;

const std::vector<std::string> kKeys = {"name", "map_resolution_m", "robot_height_m", "planar",
                                        "mount"};

YamlMap parse(const std::string& text) { return YamlMap::from_text(text, "r.yaml", kKeys); }

std::string error_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

TEST(YamlMap, ReadsValuesAndDefaults) {
  const YamlMap map = parse("name: x\nmap_resolution_m: 0.1\nplanar: false\nmount: [1, 2.5, -3]\n");
  EXPECT_EQ(map.text("name", "y"), "x");
  EXPECT_EQ(map.number("map_resolution_m", 0, 1, 0.05), 0.1);
  EXPECT_EQ(map.number("robot_height_m", 0, 1, 0.6), 0.6);
  EXPECT_FALSE(map.flag("planar", true));
  EXPECT_EQ(map.numbers("mount", 3, -9, 9, {}), (std::vector<double>{1, 2.5, -3}));
}

TEST(YamlMap, UnknownKeyNamesFileLineAndNearestKey) {
  EXPECT_EQ(
      error_of([] { parse("name: x\n\nmap_resolutoin_m: 0.1\n"); }),
      "r.yaml:3: unknown key 'map_resolutoin_m'; the nearest valid key is 'map_resolution_m'");
  EXPECT_THAT(error_of([] { parse("Planar: true\n"); }),
              HasSubstr("nearest valid key is 'planar'"));
}

TEST(YamlMap, OutOfRangeNamesFileLineKeyAndRange) {
  const YamlMap map = parse("name: x\nmap_resolution_m: 5\nmount: [1, 2, 30]\n");
  EXPECT_EQ(error_of([&] { map.number("map_resolution_m", 0.005, 1, 0.05); }),
            "r.yaml:2: 'map_resolution_m' is 5, which is not between 0.005 and 1");
  EXPECT_EQ(error_of([&] { map.numbers("mount", 3, -9, 9, {}); }),
            "r.yaml:3: 'mount' holds 30, which is not between -9 and 9");
}

TEST(YamlMap, WrongKindsAreNamed) {
  const YamlMap map = parse("name: [a]\nmap_resolution_m: wide\nplanar: perhaps\nmount: [1, 2]\n");
  EXPECT_THAT(error_of([&] { map.text("name", ""); }),
              HasSubstr("r.yaml:1: 'name' must be a word"));
  EXPECT_THAT(error_of([&] { map.number("map_resolution_m", 0, 1, 0); }),
              HasSubstr("r.yaml:2: 'map_resolution_m' must be a number"));
  EXPECT_THAT(error_of([&] { map.flag("planar", true); }),
              HasSubstr("r.yaml:3: 'planar' must be true or false"));
  EXPECT_THAT(error_of([&] { map.numbers("mount", 3, 0, 9, {}); }), HasSubstr("list of 3 numbers"));
  EXPECT_THAT(
      error_of([&] { parse("map_resolution_m: .nan\n").number("map_resolution_m", 0, 1, 0); }),
      HasSubstr("must be a number"));
}

TEST(YamlMap, ChoiceNamesTheNearest) {
  const YamlMap map = parse("name: rplidar-al\n");
  EXPECT_THAT(error_of([&] {
                map.choice("name", {"sick-lms200", "rplidar-a1"}, "");
              }),
              HasSubstr("nearest valid value is 'rplidar-a1'"));
}

TEST(YamlMap, BrokenYamlTwiceGivenAndNoMap) {
  EXPECT_THAT(error_of([] { parse("name: x\nplanar: [1,\n"); }), HasSubstr("not valid YAML"));
  EXPECT_THAT(error_of([] { parse("name: x\nname: y\n"); }),
              HasSubstr("r.yaml:2: key 'name' is given twice"));
  EXPECT_THAT(error_of([] { parse("- 1\n"); }), HasSubstr("r.yaml:1: is not a list"));
  EXPECT_THAT(error_of([] { parse(""); }), HasSubstr("r.yaml:1: is not a list"));
  EXPECT_THAT(error_of([] { parse("? [a, b]\n: 1\n"); }), HasSubstr("one word"));
  EXPECT_THAT(error_of([] { YamlMap::from_file("/nowhere.yaml", {}); }),
              HasSubstr("/nowhere.yaml"));
}

TEST(Nearest, CountsSwapsAsOneEdit) {
  EXPECT_EQ(nearest("nmae", {"nine", "name"}), "name");
  EXPECT_EQ(nearest("x", {}), "");
}

}  // namespace
}  // namespace fusion_slam
