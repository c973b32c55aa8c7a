// Small helpers of the map tests: golden files, a scratch directory, one raster that has no
// symmetry.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "libs/maps/map_raster.hpp"

namespace fusion_slam {

inline std::string read_bytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  EXPECT_TRUE(in) << file;
  std::ostringstream bytes;
  bytes << in.rdbuf();
  return bytes.str();
}

inline std::string golden(const std::string& name) {
  return read_bytes(std::filesystem::path(FS_SOURCE_DIR) / "tests/libs/maps/golden" / name);
}

// A directory of this test's own, empty at its start.
inline std::filesystem::path scratch() {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const auto directory = std::filesystem::path(testing::TempDir()) /
                         (std::string("fs_") + test->test_suite_name() + "_" + test->name());
  std::filesystem::remove_all(directory);
  std::filesystem::create_directories(directory);
  return directory;
}

// y = 4:  unknown   occupied  0.5
// y = 3:  occupied  unknown   free
//       x = -2      -1        0
inline std::map<TileIndex, FusedCells> small_map() {
  std::map<TileIndex, FusedCells> tiles;
  const auto set = [&tiles](int x, int y, double p, Provenance provenance) {
    const TileIndex index{x < 0 ? -1 : 0, 0};
    const auto i = static_cast<std::size_t>(y * kTileCells + (x < 0 ? x + kTileCells : x));
    tiles[index].probability[i] = cell_from_probability(p);
    tiles[index].provenance[i] = static_cast<std::uint8_t>(provenance);
  };
  set(-2, 3, 0.9, Provenance::kLidar);
  set(0, 3, 0.1, Provenance::kBoth);
  set(-1, 4, 0.7, Provenance::kCamera);
  set(0, 4, 0.5, Provenance::kConflict);
  return tiles;
}

inline MapRaster small_raster() {
  std::string why;
  const auto raster = make_raster(small_map(), 0.05, &why);
  EXPECT_TRUE(raster) << why;
  return raster.value_or(MapRaster{});
}

}  // namespace fusion_slam
