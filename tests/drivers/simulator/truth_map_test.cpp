#include "drivers/simulator/truth_map.hpp"

#include <gmock/gmock.h>

#include "drivers/simulator/random.hpp"
#include "drivers/simulator/truth_class.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

Box box_at(double x, double y, double z_low, Eigen::Vector3d size, double yaw = 0.0) {
  Box box;
  box.T_world_box = from_xyz_rpy(x, y, z_low + 0.5 * size.z(), 0.0, 0.0, yaw);
  box.half_m = 0.5 * size;
  return box;
}

// A closed room of 3 x 2 m (inner), walls 0.2 m thick.
std::vector<Box> room() {
  std::vector<Box> boxes = {
      box_at(1.5, -0.1, 0.0, {3.4, 0.2, 2.0}), box_at(1.5, 2.1, 0.0, {3.4, 0.2, 2.0}),
      box_at(-0.1, 1.0, 0.0, {0.2, 2.4, 2.0}), box_at(3.1, 1.0, 0.0, {0.2, 2.4, 2.0})};
  for (Box& box : boxes) box.obstacle = ObstacleClass::kWall;
  return boxes;
}

TruthOptions coarse() {
  TruthOptions options;
  options.resolution_m = 0.1;
  return options;
}

std::uint8_t cell(const TruthMap& map, double x, double y) {
  return map.raster.probability[map.raster.index(
      static_cast<int>(std::floor((x - map.raster.origin_x_m) / map.raster.resolution_m)),
      static_cast<int>(std::floor((y - map.raster.origin_y_m) / map.raster.resolution_m)))];
}
ObstacleClass class_at(const TruthMap& map, double x, double y) {
  return static_cast<ObstacleClass>(map.classes[map.raster.index(
      static_cast<int>(std::floor((x - map.raster.origin_x_m) / map.raster.resolution_m)),
      static_cast<int>(std::floor((y - map.raster.origin_y_m) / map.raster.resolution_m)))]);
}
constexpr std::uint8_t kFree = 1, kOccupied = 255;

TEST(TruthMap, InsideIsFreeWallsAreSeenOnTheirFacesAndWhatIsBehindIsUnknown) {
  const TruthMap map = make_truth_map(room(), {}, {1.0, 1.0}, coarse());
  EXPECT_TRUE(map.closed);
  std::size_t free_cells = 0, occupied = 0;
  for (const std::uint8_t c : map.raster.probability) {
    free_cells += c == kFree;
    occupied += c == kOccupied;
  }
  EXPECT_EQ(free_cells, 30U * 20U);          // touching a cell's edge is not filling it
  EXPECT_EQ(occupied, 2U * (30 + 20) + 4U);  // one cell deep, with the corners
  EXPECT_EQ(cell(map, -0.05, 1.0), kOccupied);
  EXPECT_EQ(cell(map, -0.15, 1.0), kUnknownCell);
  EXPECT_EQ(class_at(map, -0.05, 1.0), ObstacleClass::kWall);
  EXPECT_EQ(class_at(map, -0.15, 1.0), ObstacleClass::kNone);
}

TEST(TruthMap, SightGoesUnderTablesAndOverLowBoxesButNotIntoCupboards) {
  std::vector<Box> boxes = room();
  boxes.push_back(box_at(0.7, 0.7, 0.41, {0.6, 0.6, 0.04}));  // a table's top
  boxes.back().obstacle = ObstacleClass::kTable;
  boxes.push_back(box_at(1.7, 0.7, 0.0, {0.6, 0.6, 0.15}));  // a box under the LiDAR's plane
  boxes.push_back(box_at(2.6, 1.5, 0.0, {0.6, 0.6, 1.0}));   // a cupboard
  boxes.push_back(box_at(1.0, 1.5, 0.6, {0.6, 0.6, 0.5}));   // hangs above the robot
  boxes.push_back(box_at(0.3, 1.5, 0.0, {0.2, 0.2, 0.05}));  // the robot drives over it
  const TruthMap map = make_truth_map(boxes, {}, {1.2, 1.2}, coarse());
  EXPECT_EQ(cell(map, 0.75, 0.75), kOccupied);
  EXPECT_EQ(class_at(map, 0.75, 0.75), ObstacleClass::kTable);
  EXPECT_EQ(cell(map, 1.75, 0.75), kOccupied);
  EXPECT_EQ(class_at(map, 1.75, 0.75), ObstacleClass::kLowBox);
  EXPECT_EQ(cell(map, 2.35, 1.55), kOccupied);
  EXPECT_EQ(class_at(map, 2.35, 1.55), ObstacleClass::kOther);
  EXPECT_EQ(cell(map, 2.65, 1.55), kUnknownCell);
  EXPECT_EQ(cell(map, 1.05, 1.55), kFree);
  EXPECT_EQ(cell(map, 0.3, 1.5), kFree);
}

TEST(TruthMap, MeshesOfTrianglesFillWhatTheirSurfacesTouch) {
  // The faces of a closed cube, and one triangle that dips into the band with its tip.
  std::vector<TruthTriangle> triangles;
  const auto quad = [&](Eigen::Vector3d a, Eigen::Vector3d b, Eigen::Vector3d c,
                        Eigen::Vector3d d) {
    triangles.push_back({{a, b, c}, ObstacleClass::kOther});
    triangles.push_back({{a, c, d}, ObstacleClass::kOther});
  };
  const auto corner = [](int i) {
    return Eigen::Vector3d((i & 1) != 0 ? 1.03 : 0.52, (i & 2) != 0 ? 1.03 : 0.52,
                           (i & 4) != 0 ? 1.0 : 0.0);
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const int base : {0, 1 << axis}) {
      const int s = 1 << ((axis + 1) % 3), t = 1 << ((axis + 2) % 3);
      quad(corner(base), corner(base | s), corner(base | s | t), corner(base | t));
    }
  triangles.push_back({{Eigen::Vector3d(2.0, 1.0, 0.55), {2.4, 1.0, 0.75}, {2.0, 1.4, 0.75}},
                       ObstacleClass::kChair});
  const TruthMap map = make_truth_map(room(), triangles, {1.5, 0.2}, coarse());
  EXPECT_EQ(cell(map, 0.55, 0.75), kOccupied);
  EXPECT_EQ(cell(map, 1.05, 0.55), kOccupied);
  EXPECT_EQ(cell(map, 0.75, 0.75), kUnknownCell);  // inside
  EXPECT_EQ(cell(map, 1.15, 0.55), kFree);
  EXPECT_EQ(class_at(map, 2.02, 1.02), ObstacleClass::kChair);
  EXPECT_EQ(cell(map, 2.25, 1.05), kFree);  // there it is above the robot
}

// Slow and obvious: a cell is an obstacle when one of many points in it lies in a box.
TEST(TruthMap, AgreesWithPointSamplesOfRandomBoxes) {
  Random random(3);
  TruthOptions options = coarse();
  for (int round = 0; round < 8; ++round) {
    std::vector<Box> boxes = room();
    for (int i = 0; i < 6; ++i)
      boxes.push_back(box_at(
          random.uniform(0.6, 2.7), random.uniform(0.2, 1.8), random.uniform(0.0, 0.8),
          {random.uniform(0.05, 0.7), random.uniform(0.05, 0.7), 0.3}, random.uniform(-3, 3)));
    const TruthMap map = make_truth_map(boxes, {}, {0.15, 1.0}, options);
    for (int row = 0; row < map.raster.height; ++row)
      for (int column = 0; column < map.raster.width; ++column) {
        const std::uint8_t found = map.raster.probability[map.raster.index(column, row)];
        bool hit = false, near = false;
        for (int i = 0; i < 144; ++i) {
          const double x = map.raster.origin_x_m + 0.1 * (column + (i % 12 + 0.5) / 12);
          const double y = map.raster.origin_y_m + 0.1 * (row + (i / 12 + 0.5) / 12);
          for (const Box& box : boxes) {
            const double low = box.T_world_box.translation().z() - box.half_m.z();
            if (low >= options.band.high_m || low + 2 * box.half_m.z() <= options.band.low_m)
              continue;
            const Eigen::Vector3d p = box.T_world_box.inverse() *
                                      Eigen::Vector3d(x, y, box.T_world_box.translation().z());
            const Eigen::Vector3d over = p.cwiseAbs() - box.half_m;
            hit = hit || over.maxCoeff() < 0.0;
            near = near || over.maxCoeff() < 0.012;
          }
        }
        EXPECT_TRUE(!hit || found != kFree) << column << " " << row;
        EXPECT_TRUE(found != kOccupied || near) << column << " " << row;
      }
  }
}

TEST(TruthMap, NearestObstacleAgreesWithAllCells) {
  const TruthMap map = make_truth_map(room(), {}, {1.0, 1.0}, coarse());
  EXPECT_NEAR(nearest_obstacle_m(map, {0.33, 1.0}, 1.0), 0.33, 1e-9);
  EXPECT_NEAR(nearest_obstacle_m(map, {1.5, 1.0}, 0.5), 0.5, 1e-9);
  EXPECT_NEAR(nearest_obstacle_m(map, {2.9, 1.7}, 1.0), 0.1, 1e-9);
  EXPECT_EQ(nearest_obstacle_m(map, {-0.05, 1.0}, 1.0), 0.0);
}

TEST(TruthMap, SaysWhenTheWorldIsOpenAndWhenTheStartIsBlocked) {
  std::vector<Box> boxes = room();
  boxes.pop_back();
  EXPECT_FALSE(make_truth_map(boxes, {}, {1.0, 1.0}, coarse()).closed);
  try {
    make_truth_map(room(), {}, {-0.1, 1.0}, coarse());
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("(-0.100000, 1.000000), where an obstacle stands"));
  }
}

TEST(TruthClass, ModelsByName) {
  EXPECT_EQ(class_of_model("aws_robomaker_residential_ChairD_01"), ObstacleClass::kChair);
  EXPECT_EQ(class_of_model("aws_robomaker_residential_CoffeeTable_01"), ObstacleClass::kTable);
  EXPECT_EQ(class_of_model("aws_robomaker_residential_ReadingDesk_01"), ObstacleClass::kTable);
  EXPECT_EQ(class_of_model("aws_robomaker_residential_DeskPortraitA_01"), ObstacleClass::kWall);
  EXPECT_EQ(class_of_model("aws_robomaker_residential_HouseWallB_01"), ObstacleClass::kWall);
  EXPECT_EQ(class_of_model("aws_robomaker_residential_Tablet_01"), ObstacleClass::kOther);
  EXPECT_EQ(class_of_model("aws_robomaker_residential_SofaB_01"), ObstacleClass::kOther);
}

}  // namespace
}  // namespace fusion_slam
