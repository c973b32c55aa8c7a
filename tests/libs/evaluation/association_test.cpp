#include "libs/evaluation/association.hpp"

#include <cmath>
#include <random>

#include <gmock/gmock.h>

namespace fusion_slam {
namespace {

Trajectory at(const std::vector<double>& times_s) {
  Trajectory trajectory;
  for (const double t : times_s) trajectory.push_back({t, SE3::Identity()});
  return trajectory;
}

// Looks at every pose; the first of the nearest wins.
std::size_t nearest_by_looking_at_all(const Trajectory& trajectory, double time_s) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    if (std::abs(trajectory[i].time_s - time_s) < std::abs(trajectory[best].time_s - time_s))
      best = i;
  }
  return best;
}

TEST(NearestInTime, EqualsLookingAtAll) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> tenth(0,
                                           100);  // coarse, so that ties and repeated times occur
  for (int round = 0; round < 200; ++round) {
    std::vector<double> times;
    for (int i = 0; i < 1 + round % 30; ++i) times.push_back(tenth(random) / 8.0);
    std::sort(times.begin(), times.end());
    const Trajectory trajectory = at(times);
    for (int i = -8; i < 120; ++i) {
      const double t = i / 8.0 + (i % 3 == 0 ? 1.0 / 16 : 0.0);
      ASSERT_EQ(nearest_in_time(trajectory, t), nearest_by_looking_at_all(trajectory, t));
    }
  }
}

std::vector<std::pair<std::size_t, std::size_t>> pairs(const std::vector<TimeMatch>& matches) {
  std::vector<std::pair<std::size_t, std::size_t>> result;
  for (const TimeMatch& m : matches) result.emplace_back(m.reference, m.estimate);
  return result;
}

TEST(Associate, TheShorterDrives) {
  const Trajectory dense = at({0.0, 0.1, 0.2, 0.3, 0.4});
  const Trajectory sparse = at({0.11, 0.12, 0.36});
  EXPECT_THAT(pairs(associate(dense, sparse, 0.05)),
              ::testing::ElementsAre(std::pair(1, 0), std::pair(1, 1), std::pair(4, 2)));
  EXPECT_THAT(pairs(associate(sparse, dense, 0.05)),
              ::testing::ElementsAre(std::pair(0, 1), std::pair(1, 1), std::pair(2, 4)));
}

TEST(Associate, OfEquallyLongOnesTheEstimateDrives) {
  EXPECT_THAT(pairs(associate(at({0.0, 1.0}), at({0.01, 0.02}), 0.05)),
              ::testing::ElementsAre(std::pair(0, 0), std::pair(0, 1)));
}

TEST(Associate, TheBoundIsInclusive) {
  EXPECT_EQ(associate(at({1.0}), at({1.25}), 0.25).size(), 1u);
  EXPECT_EQ(associate(at({1.0}), at({1.25}), 0.2499).size(), 0u);
}

TEST(MatchPoses, ExplainsWhyNothingMatches) {
  const auto apart = match_poses(at({0.0, 1.0}), at({5.0, 6.0}), 0.01);
  EXPECT_THAT(apart.problem, ::testing::HasSubstr("don't overlap in time"));
  EXPECT_THAT(apart.problem, ::testing::HasSubstr("4 s apart"));
  const auto between = match_poses(at({0.0, 1.0}), at({0.5, 0.6}), 0.01);
  EXPECT_THAT(between.problem, ::testing::HasSubstr("try a larger --max-diff"));
  EXPECT_THAT(match_poses({}, at({0.5}), 1.0).problem, ::testing::HasSubstr("reference has no"));
  EXPECT_THAT(match_poses(at({0.5}), {}, 1.0).problem, ::testing::HasSubstr("estimate has no"));
}

}  // namespace
}  // namespace fusion_slam
