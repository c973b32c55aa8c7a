#include "libs/maps/pcd_file.hpp"

#include <gtest/gtest.h>

#include "tests/libs/maps/test_files.hpp"

namespace fusion_slam {
namespace {

TEST(PcdFile, GoldenFile) {
  const std::vector<ColouredPoint> points{{{1.5F, -2.25F, 0.125F}, 255, 0, 7},
                                          {{0.0F, 100.0F, -1e-3F}, 1, 2, 3}};
  EXPECT_EQ(pcd_bytes(points), golden("two_points.pcd"));
}

TEST(PcdFile, NoPointsAreStillAFile) {
  const std::string bytes = pcd_bytes({});
  EXPECT_NE(bytes.find("\nPOINTS 0\n"), std::string::npos);
  EXPECT_EQ(bytes.substr(bytes.size() - 12), "DATA binary\n");
}

}  // namespace
}  // namespace fusion_slam
