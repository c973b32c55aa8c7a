#include "services/fuser/fusion_rule.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

const std::uint8_t kOccupied = cell_from_probability(0.9);
const std::uint8_t kFree = cell_from_probability(0.1);

struct Row {
  std::uint8_t lidar, camera;
  CellState state;
  Provenance provenance;
};

TEST(FusionRule, Table1AsWritten) {
  const Row table[] = {
      // LiDAR, camera: the paper's rows are the camera's, its columns the LiDAR's
      {kOccupied, kOccupied, CellState::kOccupied, Provenance::kBoth},
      {kFree, kOccupied, CellState::kOccupied, Provenance::kCamera},
      {kUnknownCell, kOccupied, CellState::kOccupied, Provenance::kCamera},
      {kOccupied, kFree, CellState::kOccupied, Provenance::kConflict},
      {kFree, kFree, CellState::kUnoccupied, Provenance::kBoth},
      {kUnknownCell, kFree, CellState::kUnoccupied, Provenance::kCamera},
      {kOccupied, kUnknownCell, CellState::kOccupied, Provenance::kLidar},
      {kFree, kUnknownCell, CellState::kUnoccupied, Provenance::kLidar},
      {kUnknownCell, kUnknownCell, CellState::kUnknown, Provenance::kNone},
  };
  for (const Row& row : table) {
    const FusedCell fused = fuse_cells(row.lidar, row.camera);
    EXPECT_EQ(fused.state, row.state) << int{row.lidar} << " " << int{row.camera};
    EXPECT_EQ(fused.provenance, row.provenance) << int{row.lidar} << " " << int{row.camera};
    EXPECT_EQ(state_of_cell(fused.probability), row.state);
  }
}

TEST(FusionRule, Equation8ByHand) {
  EXPECT_NEAR(fuse_probabilities(0.7, 0.8), 0.56 / (0.56 + 0.06), 1e-15);
  EXPECT_NEAR(fuse_probabilities(0.3, 0.8), 0.24 / (0.24 + 0.14), 1e-15);
  EXPECT_NEAR(fuse_probabilities(0.2, 0.1), 0.02 / (0.02 + 0.72), 1e-15);
  EXPECT_DOUBLE_EQ(fuse_probabilities(0.37, 0.5), 0.37);  // unknown changes nothing
  EXPECT_DOUBLE_EQ(fuse_probabilities(0.0, 1.0), 0.5);
  EXPECT_EQ(fuse_cells(cell_from_probability(0.7), cell_from_probability(0.8)).probability,
            cell_from_probability(0.56 / 0.62));
}

// 0.8 and 0.3, with odds: 4 * 3/7 = 12/7, so P = 12/19.
TEST(FusionRule, Equation8InOddsByHand) {
  EXPECT_NEAR(fuse_probabilities(0.8, 0.3), 12.0 / 19.0, 1e-15);
}

TEST(FusionRule, Equation8IsCommutativeAndAssociative) {
  for (int a = 1; a < 20; ++a)
    for (int b = 1; b < 20; ++b)
      for (int c = 1; c < 20; ++c) {
        const double pa = a / 20.0, pb = b / 20.0, pc = c / 20.0;
        ASSERT_DOUBLE_EQ(fuse_probabilities(pa, pb), fuse_probabilities(pb, pa));
        ASSERT_NEAR(fuse_probabilities(fuse_probabilities(pa, pb), pc),
                    fuse_probabilities(pa, fuse_probabilities(pb, pc)), 1e-12);
      }
}

// A seat above the LiDAR's plane, a box below it: the camera says so, nobody contradicts.
TEST(FusionRule, OnlyTheCameraCanContradict) {
  EXPECT_EQ(fuse_cells(kFree, kOccupied).provenance, Provenance::kCamera);
  EXPECT_EQ(fuse_cells(kOccupied, kFree).provenance, Provenance::kConflict);
}

TEST(FusionRule, UnknownLeavesTheOtherSensorsByte) {
  EXPECT_EQ(fuse_cells(kUnknownCell, kUnknownCell).probability, kUnknownCell);
  for (int cell = 1; cell < 256; ++cell) {
    const auto byte = static_cast<std::uint8_t>(cell);
    EXPECT_EQ(fuse_cells(byte, kUnknownCell).probability, byte);
    EXPECT_EQ(fuse_cells(kUnknownCell, byte).probability, byte);
    EXPECT_EQ(fuse_cells(byte, kUnknownCell).provenance, Provenance::kLidar);
    EXPECT_EQ(fuse_cells(kUnknownCell, byte).provenance, Provenance::kCamera);
  }
}

TEST(FusionRule, AllPairsOfBytesAreSymmetricAndObeyTheTable) {
  for (int a = 0; a < 256; ++a)
    for (int b = 0; b < 256; ++b) {
      const auto lidar = static_cast<std::uint8_t>(a);
      const auto camera = static_cast<std::uint8_t>(b);
      const FusedCell fused = fuse_cells(lidar, camera);
      const FusedCell mirror = fuse_cells(camera, lidar);
      ASSERT_EQ(fused.probability, mirror.probability);
      ASSERT_EQ(fused.state, mirror.state);
      const CellState table = fuse_states(state_of_cell(lidar), state_of_cell(camera));
      if (table != CellState::kUnknown) {
        ASSERT_EQ(fused.state, table);
      }
      ASSERT_EQ(state_of_cell(fused.probability), fused.state) << a << " " << b;
      ASSERT_EQ(fused.probability == kUnknownCell, a == 0 && b == 0);
    }
}

}  // namespace
}  // namespace fusion_slam
