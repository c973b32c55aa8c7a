#include "libs/maps/ros_map_reader.hpp"

#include <fstream>

#include <gmock/gmock.h>

#include "libs/maps/ros_map.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

class RosMapReader : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) / "ros_map_reader";
    std::filesystem::create_directories(folder_);
  }
  std::filesystem::path file(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  std::string error_of(const std::string& yaml) {
    try {
      read_ros_map(file("bad.yaml", yaml));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "no error";
  }
  std::filesystem::path folder_;
};

TEST_F(RosMapReader, ReadsWhatWeWrite) {
  MapRaster raster;
  raster.resolution_m = 0.05;
  raster.origin_x_m = -1.25;
  raster.origin_y_m = 3.0;
  raster.width = 3;
  raster.height = 2;
  raster.probability = {255, 1, kUnknownCell, 1, 255, 255};
  raster.provenance.assign(6, 0);
  file("map.pgm", pgm_bytes(raster));
  const MapRaster read = read_ros_map(file("map.yaml", map_yaml(raster, "map.pgm")));
  EXPECT_EQ(read.probability, raster.probability);
  EXPECT_EQ(read.width, 3);
  EXPECT_EQ(read.height, 2);
  EXPECT_DOUBLE_EQ(read.resolution_m, 0.05);
  EXPECT_DOUBLE_EQ(read.origin_x_m, -1.25);
  EXPECT_DOUBLE_EQ(read.origin_y_m, 3.0);
}

TEST_F(RosMapReader, TheFilesOwnThresholdsAndNegate) {
  file("grey.pgm", std::string("P5\n4 1\n255\n") + std::string("\x00\x64\xCD\xFE", 4));
  const std::string start = "image: grey.pgm\nresolution: 0.1\norigin: [0, 0, 0.0]\n";
  using Cells = std::vector<std::uint8_t>;
  // map_saver's customary 205 lies below a free_thresh of 0.25, above one of 0.196.
  EXPECT_EQ(read_ros_map(file("a.yaml", start)).probability, (Cells{255, 0, 1, 1}));
  EXPECT_EQ(read_ros_map(file("b.yaml", start + "free_thresh: 0.196\n")).probability,
            (Cells{255, 0, 0, 1}));
  EXPECT_EQ(read_ros_map(file("c.yaml", start + "negate: 1\noccupied_thresh: 0.8\n")).probability,
            (Cells{1, 0, 255, 255}));
}

TEST_F(RosMapReader, ErrorsNameFileAndKey) {
  file("grey.pgm", std::string("P5\n1 1\n255\n\x01", 12));
  EXPECT_THAT(error_of("image: grey.pgm\norigin: [0, 0, 0]\n"),
              HasSubstr("'resolution' is missing"));
  EXPECT_THAT(error_of("image: grey.pgm\nresolution: 0\norigin: [0, 0, 0]\n"),
              HasSubstr("'resolution' must be above 0"));
  EXPECT_THAT(error_of("image: grey.pgm\nresolution: 0.1\norigin: [0, x, 0]\n"),
              HasSubstr("'origin' must be a number"));
  EXPECT_THAT(error_of("image: grey.pgm\nresolution: 0.1\norigin: [0, 0, 1]\n"),
              HasSubstr("the map is turned"));
  EXPECT_THAT(error_of("image: gray.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n"),
              HasSubstr("gray.pgm: is no picture"));
  EXPECT_THAT(error_of("image: grey.pgm\nmode: scale\nresolution: 0.1\norigin: [0, 0, 0]\n"),
              HasSubstr("only trinary"));
  EXPECT_THAT(error_of("resolution: 0.1\norigin: [0, 0, 0]\n"), HasSubstr("'image' is missing"));
  EXPECT_THAT(error_of("[1, 2"), HasSubstr("not valid YAML"));
  EXPECT_THAT(error_of("7"), HasSubstr("is no map.yaml"));
  EXPECT_THROW(read_ros_map(folder_ / "none.yaml"), std::runtime_error);
}

}  // namespace
}  // namespace fusion_slam
