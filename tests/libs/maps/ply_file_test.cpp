#include "libs/maps/ply_file.hpp"

#include <gtest/gtest.h>

#include "tests/libs/maps/test_files.hpp"

namespace fusion_slam {
namespace {

TEST(PlyFile, GoldenFile) {
  const std::vector<ColouredPoint> points{{{1.5F, -2.25F, 0.125F}, 255, 0, 7},
                                          {{0.0F, 100.0F, -1e-3F}, 1, 2, 3}};
  EXPECT_EQ(ply_bytes(points), golden("two_points.ply"));
}

TEST(PlyFile, NoPointsAreStillAFile) {
  const std::string bytes = ply_bytes({});
  EXPECT_NE(bytes.find("element vertex 0\n"), std::string::npos);
  EXPECT_EQ(bytes.substr(bytes.size() - 11), "end_header\n");
}

}  // namespace
}  // namespace fusion_slam
