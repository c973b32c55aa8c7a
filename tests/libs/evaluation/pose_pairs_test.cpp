#include "libs/evaluation/pose_pairs.hpp"

#include <cmath>

#include <gmock/gmock.h>

#include "tests/libs/evaluation/made_up.hpp"

namespace fusion_slam {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Along x, one step of 1 m per pose unless said otherwise; turning 4 degrees a pose.
Trajectory line(const std::vector<double>& x_m) {
  Trajectory trajectory;
  for (std::size_t i = 0; i < x_m.size(); ++i) {
    const double yaw = 4.0 * M_PI / 180.0 * static_cast<double>(i);
    trajectory.push_back({static_cast<double>(i), from_xyz_rpy(x_m[i], 0, 0, 0, 0, yaw)});
  }
  return trajectory;
}

IndexPair p(std::size_t i, std::size_t j) { return {i, j}; }

TEST(PosePairs, Frames) {
  const Trajectory t = line({0, 1, 2, 3, 4, 5});
  EXPECT_THAT(select_pairs(t, 2, DeltaUnit::kFrames, false), ElementsAre(p(0, 2), p(2, 4)));
  EXPECT_THAT(select_pairs(t, 2, DeltaUnit::kFrames, true),
              ElementsAre(p(0, 2), p(1, 3), p(2, 4), p(3, 5)));
  EXPECT_THAT(select_pairs(t, 6, DeltaUnit::kFrames, true), IsEmpty());
}

TEST(PosePairs, ConsecutiveMetersSkipThePieceBeforeTheFirstCut) {
  EXPECT_THAT(select_pairs(line({0, 1, 2, 3, 4, 5, 6}), 2, DeltaUnit::kMeters, false),
              ElementsAre(p(2, 4), p(4, 6)));
  // There and back again: the path counts, not the direct distance.
  EXPECT_THAT(select_pairs(line({0, 1, 0, 1, 0}), 2, DeltaUnit::kMeters, false),
              ElementsAre(p(2, 4)));
}

TEST(PosePairs, ConsecutiveDegreesStartAtTheFirstPose) {
  EXPECT_THAT(select_pairs(line({0, 1, 2, 3, 4, 5, 6}), 10, DeltaUnit::kDegrees, false),
              ElementsAre(p(0, 3), p(3, 6)));
}

TEST(PosePairs, AllDegreesTakeEveryPairWithinTenPercent) {
  EXPECT_THAT(select_pairs(line({0, 1, 2, 3, 4}), 8.5, DeltaUnit::kDegrees, true),
              ElementsAre(p(0, 2), p(1, 3), p(2, 4)));
  EXPECT_THAT(select_pairs(line({0, 1, 2, 3, 4}), 10, DeltaUnit::kDegrees, true), IsEmpty());
}

TEST(PosePairs, AllMetersTakeTheFirstNearest) {
  // Stands still at 2 m: of the equally near poses the first counts.
  EXPECT_THAT(select_pairs(line({0, 1, 2, 2, 2, 3}), 2, DeltaUnit::kMeters, true),
              ElementsAre(p(0, 2), p(1, 5)));
}

TEST(PosePairs, AllMetersEqualLookingAtAll) {
  std::mt19937 random(7);
  for (int round = 0; round < 20; ++round) {
    const Trajectory walk = random_walk(random, 120);
    std::vector<double> path(walk.size(), 0.0);
    for (std::size_t i = 1; i < walk.size(); ++i) {
      path[i] =
          path[i - 1] +
          (walk[i].T_world_body.translation() - walk[i - 1].T_world_body.translation()).norm();
    }
    for (const double delta : {0.01, 0.3, 1.0, 4.0, 100.0}) {
      std::vector<IndexPair> expected;
      for (std::size_t i = 0; i + 1 < walk.size(); ++i) {
        std::size_t best = i + 1;
        for (std::size_t j = i + 2; j < walk.size(); ++j) {
          if (std::abs(path[j] - path[i] - delta) < std::abs(path[best] - path[i] - delta))
            best = j;
        }
        if (std::abs(path[best] - path[i] - delta) <= 0.1 * delta) expected.emplace_back(i, best);
      }
      EXPECT_EQ(select_pairs(walk, delta, DeltaUnit::kMeters, true), expected);
    }
  }
}

TEST(PosePairs, NothingOfNothing) {
  for (const bool all : {false, true}) {
    for (const DeltaUnit unit : {DeltaUnit::kFrames, DeltaUnit::kMeters, DeltaUnit::kDegrees}) {
      EXPECT_THAT(select_pairs({}, 1, unit, all), IsEmpty());
      EXPECT_THAT(select_pairs(line({0}), 1, unit, all), IsEmpty());
    }
  }
}

}  // namespace
}  // namespace fusion_slam
