// What a reader that knows nothing of Fusion-SLAM (plain Python, written from the documentation of
// map_server and nav2) gets of our map.yaml and map.pgm: each cell in its place, in its state.
#include <cstdio>
#include <set>

#include "libs/maps/ros_map.hpp"
#include "tests/libs/maps/test_files.hpp"

namespace fusion_slam {
namespace {

std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  char part[256];
  while (std::fgets(part, sizeof part, pipe) != nullptr) text += part;
  EXPECT_EQ(pclose(pipe), 0) << command;
  return text;
}

TEST(IndependentReader, FindsEachCellInItsPlace) {
  if (std::system("python3 -c pass 2> /dev/null") != 0) GTEST_SKIP() << "no python3";
  const auto directory = scratch();
  const MapRaster raster = small_raster();
  std::ofstream(directory / "m.pgm", std::ios::binary) << pgm_bytes(raster);
  std::ofstream(directory / "m.yaml") << map_yaml(raster, "m.pgm");
  const std::string script = std::string(FS_SOURCE_DIR) + "/tests/libs/maps/read_ros_map.py";
  const std::string text =
      output_of("python3 '" + script + "' '" + (directory / "m.yaml").string() + "'");
  // small_map(): walls in cells (-2, 3) and (-1, 4), floor in (0, 3); cells of 5 cm.
  EXPECT_EQ(text,
            "0.05 3 2\n"
            "-0.075 0.175 100\n"
            "0.025 0.175 0\n"
            "-0.025 0.225 100\n");
}

}  // namespace
}  // namespace fusion_slam
