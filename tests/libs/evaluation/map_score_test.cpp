#include "libs/evaluation/map_score.hpp"

#include <random>

#include <gmock/gmock.h>

namespace fusion_slam {
namespace {

// Rows of text from the largest y down: '#' occupied, '.' free, anything else unknown.
MapRaster drawn(const std::vector<std::string>& rows, double resolution_m = 1.0) {
  MapRaster raster;
  raster.resolution_m = resolution_m;
  raster.width = static_cast<int>(rows.front().size());
  raster.height = static_cast<int>(rows.size());
  for (auto row = rows.rbegin(); row != rows.rend(); ++row)
    for (const char c : *row)
      raster.probability.push_back(c == '#'   ? cell_from_probability(1.0)
                                   : c == '.' ? cell_from_probability(0.0)
                                              : kUnknownCell);
  raster.provenance.assign(raster.probability.size(), 0);
  return raster;
}

TEST(MapScore, GoldenByHand) {
  const MapRaster reference = drawn({"######",  //
                                     "#....#",  //
                                     "#.#..#",  //
                                     "#....#",  //
                                     "######"});
  const MapRaster estimate = drawn({"######",  //
                                    "#....#",  //
                                    "#...##",  // the middle obstacle missed; a false one at (4, 2)
                                    "#.? .#",  //
                                    "#####?"});
  std::vector<std::uint8_t> classes(30, 0);
  for (std::size_t i = 0; i < classes.size(); ++i)
    if (reference.probability[i] == 255) classes[i] = 1;
  classes[reference.index(2, 2)] = 3;
  const auto same = resample(reference, estimate, SE2{});
  ASSERT_TRUE(same);

  const MapScore strict = score_map(reference, classes, *same, 0);
  EXPECT_EQ(strict.estimate_occupied, 18U);
  EXPECT_EQ(strict.estimate_right, 17U);
  EXPECT_EQ(strict.false_in_free, 1U);
  EXPECT_EQ(strict.false_in_unknown, 0U);
  EXPECT_EQ(strict.occupied.cells, 19U);
  EXPECT_EQ(strict.occupied.found, 17U);
  EXPECT_EQ(strict.occupied.called_free, 1U);  // the corner is unknown, the middle is called free
  EXPECT_EQ(strict.by_class[1].cells, 18U);
  EXPECT_EQ(strict.by_class[1].found, 17U);
  EXPECT_EQ(strict.by_class[3].cells, 1U);
  EXPECT_EQ(strict.by_class[3].found, 0U);
  EXPECT_EQ(strict.by_class[3].called_free, 1U);
  EXPECT_EQ(strict.reference_free, 11U);
  EXPECT_EQ(strict.free_right, 8U);
  EXPECT_EQ(strict.free_wrong, 1U);
  EXPECT_DOUBLE_EQ(strict.precision(), 17.0 / 18.0);
  EXPECT_DOUBLE_EQ(strict.recall(), 17.0 / 19.0);
  EXPECT_DOUBLE_EQ(strict.f1(), 2.0 * 17.0 / (18.0 + 19.0));
  EXPECT_DOUBLE_EQ(strict.iou(), 17.0 / 20.0);
  EXPECT_DOUBLE_EQ(strict.free_accuracy(), 8.0 / 9.0);
  EXPECT_DOUBLE_EQ(strict.free_coverage(), 9.0 / 11.0);

  // With a tolerance of one cell the false one belongs to the wall, the corner to its neighbours;
  // the middle is two cells from anything.
  const MapScore lenient = score_map(reference, classes, *same, 1);
  EXPECT_EQ(lenient.estimate_right, 18U);
  EXPECT_EQ(lenient.occupied.found, 18U);
  EXPECT_EQ(lenient.by_class[3].found, 0U);
  EXPECT_EQ(lenient.free_wrong, 0U);
  EXPECT_EQ(lenient.free_excused, 1U);
  EXPECT_EQ(lenient.reference_free, 10U);
  EXPECT_DOUBLE_EQ(lenient.free_accuracy(), 1.0);
}

TEST(MapScore, CellsOutsideTheReferenceAreFalse) {
  const MapRaster reference = drawn({"#."});
  MapRaster estimate = drawn({"#..#"});
  const auto resampled = resample(reference, estimate, SE2{});
  ASSERT_TRUE(resampled);
  const MapScore score = score_map(reference, {}, *resampled, 1);
  EXPECT_EQ(score.estimate_occupied, 2U);
  EXPECT_EQ(score.false_in_unknown, 1U);
  EXPECT_EQ(score.by_class[0].cells, 1U);
}

// Slow and obvious: all pairs of cells.
TEST(MapScore, AgreesWithAllPairsOfRandomMaps) {
  std::mt19937 random(1);
  const auto random_map = [&](int width, int height) {
    std::vector<std::string> rows(static_cast<std::size_t>(height));
    for (auto& row : rows)
      for (int i = 0; i < width; ++i) row += "##......? "[random() % 10];
    return drawn(rows);
  };
  for (int round = 0; round < 30; ++round) {
    const MapRaster reference = random_map(9, 7);
    MapRaster estimate = random_map(8, 10);
    estimate.origin_x_m = -2.0;
    estimate.origin_y_m = 1.0;
    const int tolerance = round % 3;
    const auto resampled = resample(reference, estimate, SE2{});
    ASSERT_TRUE(resampled);
    const MapScore score = score_map(reference, {}, *resampled, tolerance);
    const auto is = [](const MapRaster& m, int column, int row) {
      return column >= 0 && row >= 0 && column < m.width && row < m.height &&
             m.probability[m.index(column, row)] == 255;
    };
    std::size_t found = 0, right = 0;
    const auto near = [&](const MapRaster& m, int column, int row) {
      bool any = false;
      for (int c = -30; c < 30; ++c)
        for (int r = -30; r < 30; ++r)
          any = any ||
                (is(m, c, r) && std::max(std::abs(c - column), std::abs(r - row)) <= tolerance);
      return any;
    };
    for (int c = 0; c < 20; ++c)
      for (int r = 0; r < 20; ++r) {
        found += is(reference, c, r) && near(estimate, c + 2, r - 1);
        right += is(estimate, c, r) && near(reference, c - 2, r + 1);
      }
    EXPECT_EQ(score.occupied.found, found);
    EXPECT_EQ(score.estimate_right, right);
  }
}

// A map drawn in a turned and moved frame scores as itself.
TEST(MapScore, ATurnedEstimateIsBroughtBack) {
  MapRaster reference;
  reference.resolution_m = 0.05;
  reference.width = 120;
  reference.height = 90;
  reference.provenance.assign(120 * 90, 0);
  for (int row = 0; row < 90; ++row)
    for (int column = 0; column < 120; ++column) {
      const bool wall =
          row < 2 || row > 87 || column < 2 || column > 117 || (row == 40 && column > 60);
      reference.probability.push_back(cell_from_probability(wall ? 1.0 : 0.0));
    }
  const SE2 T_ref_est{1.3, -0.7, 0.5};
  for (const double resolution_m : {0.05, 0.1, 0.025}) {
    MapRaster estimate;
    estimate.resolution_m = resolution_m;
    estimate.origin_x_m = -5.0;
    estimate.origin_y_m = -5.0;
    estimate.width = estimate.height = static_cast<int>(std::lround(13.0 / resolution_m));
    for (int row = 0; row < estimate.height; ++row)
      for (int column = 0; column < estimate.width; ++column) {
        // An occupied cell is one that a reference cell's middle lies in; free likewise.
        const Eigen::Vector2d p = T_ref_est * Eigen::Vector2d(-5.0 + (column + 0.5) * resolution_m,
                                                              -5.0 + (row + 0.5) * resolution_m);
        const int c = static_cast<int>(std::floor(p.x() / 0.05)),
                  r = static_cast<int>(std::floor(p.y() / 0.05));
        estimate.probability.push_back(c < 0 || r < 0 || c >= 120 || r >= 90
                                           ? kUnknownCell
                                           : reference.probability[reference.index(c, r)]);
      }
    estimate.provenance.assign(estimate.probability.size(), 0);
    const auto resampled = resample(reference, estimate, T_ref_est);
    ASSERT_TRUE(resampled);
    const MapScore score = score_map(reference, {}, *resampled, 1);
    EXPECT_GT(score.precision(), 0.999) << resolution_m;
    EXPECT_GT(score.recall(), resolution_m > 0.05 ? 0.98 : 0.999) << resolution_m;
    EXPECT_GT(score.free_accuracy(), 0.999) << resolution_m;
    EXPECT_GT(score.free_coverage(), 0.95) << resolution_m;
  }
}

TEST(MapScore, AlignsByTrajectories) {
  const SE3 T_ref_est = from_xyz_rpy(2.0, -1.0, 0.0, 0.0, 0.0, 0.7);
  Trajectory reference, estimate;
  for (int i = 0; i < 20; ++i) {
    const SE3 T_est_body = from_xyz_rpy(0.1 * i, 0.02 * i * i, 0.0, 0.0, 0.0, 0.1 * i);
    estimate.push_back({1.0 * i, T_est_body});
    reference.push_back({1.0 * i, T_ref_est * T_est_body});
  }
  const auto alignment = align_maps(reference, estimate, 0.01);
  ASSERT_TRUE(alignment) << alignment.problem;
  EXPECT_NEAR(alignment->T_ref_est.x, 2.0, 1e-9);
  EXPECT_NEAR(alignment->T_ref_est.y, -1.0, 1e-9);
  EXPECT_NEAR(alignment->T_ref_est.yaw, 0.7, 1e-9);
  EXPECT_NEAR(alignment->tilt_rad, 0.0, 1e-6);
  EXPECT_EQ(alignment->matched, 20U);
  EXPECT_FALSE(align_maps(reference, {{100.0, SE3::Identity()}}, 0.01));
}

TEST(MapScore, AStraightDriveAligns) {
  const SE3 T_ref_est = from_xyz_rpy(2.0, -1.0, 0.0, 0.0, 0.0, -2.5);
  Trajectory reference, estimate;
  for (int i = 0; i < 20; ++i) {
    const SE3 T_est_body = from_xyz_rpy(0.1 * i, 0.3, 0.0, 0.0, 0.0, 0.0);
    estimate.push_back({1.0 * i, T_est_body});
    reference.push_back({1.0 * i, T_ref_est * T_est_body});
  }
  const auto alignment = align_maps(reference, estimate, 0.01);
  ASSERT_TRUE(alignment) << alignment.problem;
  EXPECT_NEAR(alignment->T_ref_est.x, 2.0, 1e-9);
  EXPECT_NEAR(alignment->T_ref_est.y, -1.0, 1e-9);
  EXPECT_NEAR(alignment->T_ref_est.yaw, -2.5, 1e-9);
  EXPECT_NEAR(alignment->rmse_m, 0.0, 1e-9);
  for (StampedPose& pose : estimate) pose.T_world_body = SE3::Identity();  // stands still
  EXPECT_FALSE(align_maps(reference, estimate, 0.01));
}

TEST(MapScore, AnAbsurdlyLargeMapIsAFailure) {
  const MapRaster reference = drawn({"#."}, 1e-6);
  const MapRaster estimate = drawn({"#."}, 1.0);
  EXPECT_FALSE(resample(reference, estimate, SE2{}));
}

TEST(MapClass, NamesThereAndBack) {
  for (std::size_t i = 1; i < kObstacleClasses; ++i)
    EXPECT_EQ(obstacle_class_from(kObstacleClassNames[i]), static_cast<ObstacleClass>(i));
  EXPECT_FALSE(obstacle_class_from("none"));
  EXPECT_FALSE(obstacle_class_from("sofa"));
}

}  // namespace
}  // namespace fusion_slam
