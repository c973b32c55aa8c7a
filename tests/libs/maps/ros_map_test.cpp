#include "libs/maps/ros_map.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/libs/maps/test_files.hpp"

namespace fusion_slam {
namespace {

// A reader of its own, by the definition on wiki.ros.org/map_server: "key: value" lines.
std::map<std::string, std::string> read_yaml(const std::string& text) {
  std::map<std::string, std::string> values;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const auto colon = line.find(": ");
    EXPECT_NE(colon, std::string::npos) << line;
    values[line.substr(0, colon)] = line.substr(colon + 2);
  }
  return values;
}

struct Pgm {
  int width = 0;
  int height = 0;
  std::string pixels;
};

Pgm read_pgm(const std::string& bytes) {
  std::istringstream in(bytes);
  std::string magic;
  std::string comment;
  int max = 0;
  Pgm pgm;
  std::getline(in, magic);
  std::getline(in, comment);
  in >> pgm.width >> pgm.height >> max;
  in.get();
  EXPECT_EQ(magic, "P5");
  EXPECT_EQ(comment[0], '#');
  EXPECT_EQ(max, 255);
  pgm.pixels = bytes.substr(static_cast<std::size_t>(in.tellg()));
  EXPECT_EQ(pgm.pixels.size(), static_cast<std::size_t>(pgm.width * pgm.height));
  return pgm;
}

TEST(RosMap, GoldenFiles) {
  EXPECT_EQ(pgm_bytes(small_raster()), golden("small.pgm"));
  EXPECT_EQ(map_yaml(small_raster(), "map.pgm"), golden("small.yaml"));
}

// What a map_server would answer for a point in the map, pixel value straight from the two files.
TEST(RosMap, EveryCellIsFoundWhereMapServerLooksForIt) {
  std::mt19937 rng(1);
  std::map<TileIndex, FusedCells> tiles;
  for (const TileIndex& index : {TileIndex{-2, 1}, TileIndex{0, 0}, TileIndex{1, -1}})
    for (auto& cell : tiles[index].probability) cell = static_cast<std::uint8_t>(rng() % 256);
  std::string why;
  const auto raster = make_raster(tiles, 0.1, &why);
  ASSERT_TRUE(raster) << why;
  const auto yaml = read_yaml(map_yaml(*raster, "map.pgm"));
  const Pgm pgm = read_pgm(pgm_bytes(*raster));
  EXPECT_EQ(yaml.at("image"), "map.pgm");
  EXPECT_EQ(yaml.at("mode"), "trinary");
  EXPECT_EQ(yaml.at("negate"), "0");
  EXPECT_EQ(yaml.at("occupied_thresh"), "0.65");
  EXPECT_EQ(yaml.at("free_thresh"), "0.25");
  const double resolution = std::stod(yaml.at("resolution"));
  double origin_x = 0.0;
  double origin_y = 0.0;
  double yaw = 1.0;
  ASSERT_EQ(std::sscanf(yaml.at("origin").c_str(), "[%lf, %lf, %lf]", &origin_x, &origin_y, &yaw),
            3);
  EXPECT_EQ(yaw, 0.0);
  for (const auto& [index, cells] : tiles) {
    for (int i = 0; i < kTileCells * kTileCells; ++i) {
      const double x = (index.first * kTileCells + i % kTileCells + 0.5) * 0.1;
      const double y = (index.second * kTileCells + i / kTileCells + 0.5) * 0.1;
      const int column = static_cast<int>(std::floor((x - origin_x) / resolution));
      const int from_bottom = static_cast<int>(std::floor((y - origin_y) / resolution));
      if (column < 0 || column >= pgm.width || from_bottom < 0 || from_bottom >= pgm.height) {
        EXPECT_EQ(cells.probability[static_cast<std::size_t>(i)], kUnknownCell);
        continue;
      }
      const int row = pgm.height - 1 - from_bottom;
      const auto pixel = static_cast<unsigned char>(
          pgm.pixels[static_cast<std::size_t>(row * pgm.width + column)]);
      const CellState state = state_of_cell(cells.probability[static_cast<std::size_t>(i)]);
      // As map_server reads it: by the thresholds in the YAML.
      const double occupied = (255.0 - pixel) / 255.0;
      const CellState read = occupied > std::stod(yaml.at("occupied_thresh")) ? CellState::kOccupied
                             : occupied < std::stod(yaml.at("free_thresh")) ? CellState::kUnoccupied
                                                                            : CellState::kUnknown;
      EXPECT_EQ(read, state) << static_cast<int>(pixel);
    }
  }
}

}  // namespace
}  // namespace fusion_slam
