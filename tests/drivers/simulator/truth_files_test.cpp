#include "drivers/simulator/truth_files.hpp"

#include <fstream>
#include <iterator>

#include <gmock/gmock.h>

namespace fusion_slam {
namespace {

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

World small_world() {
  World world;
  const auto add = [&](double x, double y, double size_x, double size_y, ObstacleClass obstacle) {
    Box box;
    box.T_world_box.translation() = Eigen::Vector3d(x, y, 0.1);
    box.half_m = Eigen::Vector3d(0.5 * size_x, 0.5 * size_y, 0.1);
    box.obstacle = obstacle;
    world.boxes.push_back(box);
  };
  add(1.0, 0.25, 2.0, 0.5, ObstacleClass::kWall);
  add(1.0, 1.75, 2.0, 0.5, ObstacleClass::kWall);
  add(0.25, 1.0, 0.5, 1.0, ObstacleClass::kChair);
  add(1.75, 1.0, 0.5, 1.0, ObstacleClass::kOther);
  return world;
}

TEST(TruthFiles, GoldenMapAndClasses) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "truth_files";
  std::filesystem::remove_all(folder);
  RobotModel robot;
  robot.has_lidar = true;
  robot.T_base_lidar.translation().z() = 0.3;
  const TruthMap map = write_truth(small_world(), {{1.0, 1.0}, {1.2, 1.0}}, robot, 0.5, folder);
  EXPECT_TRUE(map.closed);
  // 6 x 6 cells from (-0.5, -0.5): a free square of 2 x 2, around it what can be seen: low walls,
  // so all of it.
  const unsigned char u = 128, o = 0, f = 254;
  const std::vector<unsigned char> cells = {u, u, u, u, u, u, u, o, o, o, o, u, u, o, f, f, o, u,
                                            u, o, f, f, o, u, u, o, o, o, o, u, u, u, u, u, u, u};
  EXPECT_EQ(bytes_of(folder / "map.pgm"),
            "P5\n# Fusion-SLAM 0.5 m/pixel\n6 6\n255\n" + std::string(cells.begin(), cells.end()));
  EXPECT_THAT(bytes_of(folder / "map.yaml"), testing::HasSubstr("origin: [-0.5, -0.5, 0]"));
  const std::vector<unsigned char> classes = {0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 3, 0, 0, 5, 0,
                                              0, 3, 0, 0, 5, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(bytes_of(folder / "classes.pgm"),
            "P5\n6 6\n255\n" + std::string(classes.begin(), classes.end()));
  EXPECT_GT(std::filesystem::file_size(folder / "surfaces.ply"), 100U);
  EXPECT_GT(std::filesystem::file_size(folder / "map.png"), 100U);
}

TEST(TruthFiles, SurfacePointsLieOnTheSurfacesAtTheSpacing) {
  Box box;
  box.T_world_box.translation() = Eigen::Vector3d(0.0, 0.0, 0.5);
  box.half_m = Eigen::Vector3d(0.5, 0.5, 0.5);
  const auto points = sample_surfaces({box}, {}, 0.1);
  EXPECT_EQ(points.size(), 6U * 100U);
  for (const ColouredPoint& p : points) {
    const Eigen::Vector3f d = p.p_m - Eigen::Vector3f(0.0F, 0.0F, 0.5F);
    EXPECT_NEAR(d.cwiseAbs().maxCoeff(), 0.5F, 1e-6F);
  }
  const TruthTriangle triangle{{Eigen::Vector3d(0, 0, 1), {1, 0, 1}, {0, 1, 1}},
                               ObstacleClass::kTable};
  const auto on_triangle = sample_surfaces({}, {triangle}, 0.1);
  EXPECT_NEAR(static_cast<double>(on_triangle.size()), 55.0, 6.0);
  for (const ColouredPoint& p : on_triangle) {
    EXPECT_FLOAT_EQ(p.p_m.z(), 1.0F);
    EXPECT_GT(p.p_m.x(), 0.0F);
    EXPECT_LT(p.p_m.x() + p.p_m.y(), 1.0F);
  }
}

TEST(TruthFiles, AMapNeedsAStart) {
  EXPECT_THROW(write_truth(small_world(), {}, RobotModel(), 0.5, testing::TempDir()),
               std::runtime_error);
}

}  // namespace
}  // namespace fusion_slam
