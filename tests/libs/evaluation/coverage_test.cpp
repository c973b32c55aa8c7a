#include "libs/evaluation/coverage.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

// One pose each `period_s` in [begin_s, end_s).
Trajectory steady(double begin_s, double end_s, double period_s) {
  Trajectory trajectory;
  const auto count = static_cast<int>((end_s - begin_s) / period_s + 0.5);
  for (int i = 0; i < count; ++i) trajectory.push_back({begin_s + i * period_s, SE3::Identity()});
  return trajectory;
}

Trajectory joined(Trajectory a, const Trajectory& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(Coverage, APoseForEachReferencePoseIsAll) {
  const Trajectory t = steady(0.0, 10.0, 0.1);
  EXPECT_DOUBLE_EQ(compute_coverage(t, t).percent, 100.0);
}

TEST(Coverage, ADenserReferenceIsNoReproach) {
  const Coverage c = compute_coverage(steady(0.0, 10.0, 0.01), steady(0.0, 10.01, 1.0 / 30));
  EXPECT_NEAR(c.percent, 100.0, 0.5);
  EXPECT_NEAR(c.allowed_gap_s, 0.1, 1e-9);
}

TEST(Coverage, LostTimeCountsInFull) {
  const Trajectory estimate = joined(steady(0.0, 4.0, 0.1), steady(6.0, 10.1, 0.1));
  const Coverage c = compute_coverage(steady(0.0, 10.1, 0.1), estimate);
  EXPECT_NEAR(c.percent, 79.0, 1e-6);  // from 3.9 to 6.0 there is nothing
  EXPECT_NEAR(c.longest_gap_s, 2.1, 1e-9);
  ASSERT_EQ(c.lost.size(), 1u);
  EXPECT_NEAR(c.lost[0].begin_s, 3.9, 1e-9);
  EXPECT_NEAR(c.lost[0].end_s, 6.0, 1e-9);
}

TEST(Coverage, TwoMissingPosesAreBridgedThreeAreNot) {
  const Trajectory reference = steady(0.0, 10.1, 0.1);
  Trajectory two = reference;
  two.erase(two.begin() + 50, two.begin() + 52);
  EXPECT_NEAR(compute_coverage(reference, two).percent, 100.0, 1e-9);
  Trajectory three = reference;
  three.erase(three.begin() + 50, three.begin() + 53);
  EXPECT_NEAR(compute_coverage(reference, three).percent, 96.0, 1e-6);
}

TEST(Coverage, StartingLateOrStoppingEarlyCounts) {
  const Coverage c = compute_coverage(steady(0.0, 10.1, 0.1), steady(2.0, 5.1, 0.1));
  EXPECT_NEAR(c.percent, 30.0, 1e-6);
  EXPECT_NEAR(c.longest_gap_s, 5.0, 1e-6);
}

TEST(Coverage, AWindowLimitsTheQuestion) {
  // The reference starts long before the recording.
  const Trajectory reference = steady(-20.0, 30.0, 0.01);
  const Trajectory estimate = steady(0.0, 10.1, 0.1);
  EXPECT_NEAR(compute_coverage(reference, estimate, TimeWindow{0.0, 10.0}).percent, 100.0, 1e-9);
  EXPECT_NEAR(compute_coverage(reference, estimate, TimeWindow{5.0, 15.0}).percent, 50.0, 1e-6);
  EXPECT_NEAR(compute_coverage(reference, estimate, TimeWindow{20.0, 30.0}).percent, 0.0, 1e-9);
}

TEST(Coverage, FewSparsePosesDoNotCoverADenseReference) {
  EXPECT_NEAR(compute_coverage(steady(0.0, 30.0, 0.01), steady(0.0, 31.0, 2.0)).percent, 0.0, 1e-9);
}

TEST(Coverage, ASparseReferenceAllowsASparseEstimate) {
  EXPECT_NEAR(compute_coverage(steady(0.0, 31.0, 2.0), steady(0.0, 31.0, 2.0)).percent, 100.0,
              1e-9);
}

TEST(Coverage, APauseOfTheSensorIsNobodysFault) {
  const Trajectory pauses = joined(steady(0.0, 4.0, 0.1), steady(6.0, 10.0, 0.1));
  EXPECT_NEAR(compute_coverage(pauses, pauses).percent, 100.0, 1e-9);
  // But a reference that says nothing for long proves nothing.
  const Trajectory silent = joined(steady(0.0, 4.0, 0.1), steady(8.0, 10.0, 0.1));
  EXPECT_LT(compute_coverage(silent, silent).percent, 60.0);
}

TEST(Coverage, OfNothingIsZero) {
  const Coverage c = compute_coverage(steady(0.0, 10.1, 0.1), {});
  EXPECT_EQ(c.percent, 0.0);
  EXPECT_NEAR(c.longest_gap_s, 10.0, 1e-9);
  EXPECT_EQ(compute_coverage({}, {}).percent, 0.0);
  EXPECT_EQ(compute_coverage(steady(0.0, 10.0, 0.1), {{5.0, SE3::Identity()}}).percent, 0.0);
}

}  // namespace
}  // namespace fusion_slam
