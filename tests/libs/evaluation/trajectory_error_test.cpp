#include "libs/evaluation/trajectory_error.hpp"

#include <gmock/gmock.h>

#include "tests/libs/evaluation/made_up.hpp"

namespace fusion_slam {
namespace {

using ::testing::HasSubstr;

constexpr ErrorRelation kRelations[] = {ErrorRelation::kTranslation, ErrorRelation::kRotation,
                                        ErrorRelation::kFull};

EvaluationOptions with(Alignment alignment, ErrorRelation relation = ErrorRelation::kTranslation) {
  EvaluationOptions options;
  options.alignment = alignment;
  options.relation = relation;
  return options;
}

struct Walks {
  Trajectory reference;
  Trajectory estimate;
};

Walks walks(unsigned seed) {
  std::mt19937 random(seed);
  Walks w;
  w.reference = random_walk(random, 200);
  w.estimate = with_noise(random, w.reference, 0.05, 0.05);
  return w;
}

TEST(Ape, IsZeroForTheTruthItself) {
  const Walks w = walks(1);
  for (const ErrorRelation relation : kRelations) {
    const auto result = evaluate_ape(w.reference, w.reference, with(Alignment::kSe3, relation));
    ASSERT_TRUE(result) << result.problem;
    EXPECT_NEAR(result->statistics.max, 0.0, 1e-10);
    EXPECT_NEAR(result->coverage.percent, 100.0, 1e-9);
  }
}

TEST(Ape, IsTheSameAfterACommonRigidMotion) {
  for (unsigned seed = 1; seed < 6; ++seed) {
    const Walks w = walks(seed);
    std::mt19937 random(seed + 100);
    const SE3 T = random_pose(random, 50.0, 3.0);
    for (const ErrorRelation relation : kRelations) {
      const auto before = evaluate_ape(w.reference, w.estimate, with(Alignment::kSe3, relation));
      const auto both = evaluate_ape(moved(T, w.reference), moved(T, w.estimate),
                                     with(Alignment::kSe3, relation));
      const auto estimate_only =
          evaluate_ape(w.reference, moved(T, w.estimate), with(Alignment::kSe3, relation));
      ASSERT_TRUE(before && both && estimate_only);
      EXPECT_NEAR(both->statistics.rmse, before->statistics.rmse, 1e-10);
      EXPECT_NEAR(estimate_only->statistics.rmse, before->statistics.rmse, 1e-10);
    }
  }
}

TEST(Ape, AlignmentNeverMakesThePositionErrorWorse) {
  const Walks w = walks(9);
  const double none = evaluate_ape(w.reference, w.estimate, {})->statistics.rmse;
  const double se3 = evaluate_ape(w.reference, w.estimate, with(Alignment::kSe3))->statistics.rmse;
  const double sim3 =
      evaluate_ape(w.reference, w.estimate, with(Alignment::kSim3))->statistics.rmse;
  EXPECT_LE(se3, none);
  EXPECT_LE(sim3, se3);
}

TEST(Ape, Sim3RecoversTheScale) {
  Walks w = walks(3);
  for (StampedPose& pose : w.estimate) pose.T_world_body.translation() *= 0.25;
  w.estimate = moved(from_xyz_rpy(1, 2, 3, 0.1, 0.2, 0.3), w.estimate);
  const auto result = evaluate_ape(w.reference, w.estimate, with(Alignment::kSim3));
  ASSERT_TRUE(result) << result.problem;
  EXPECT_NEAR(result->alignment.scale, 4.0, 0.1);
}

TEST(Ape, KnownOffset) {
  const Trajectory reference = walks(4).reference;
  const SE3 T = from_xyz_rpy(0.3, 0.0, 0.4, 0.0, 0.0, M_PI / 6.0);
  Trajectory estimate = reference;
  for (StampedPose& pose : estimate) pose.T_world_body = pose.T_world_body * T;
  EXPECT_NEAR(evaluate_ape(reference, estimate, {})->statistics.mean, 0.5, 1e-12);
  EXPECT_NEAR(evaluate_ape(reference, estimate, with(Alignment::kNone, ErrorRelation::kRotation))
                  ->statistics.mean,
              30.0, 1e-10);
}

TEST(Rpe, DoesNotDependOnAnyRigidAlignment) {
  const Walks w = walks(5);
  std::mt19937 random(6);
  const Trajectory elsewhere = moved(random_pose(random, 9.0, 2.0), w.estimate);
  const auto here = evaluate_rpe(w.reference, w.estimate, {}, {});
  const auto there = evaluate_rpe(w.reference, elsewhere, {}, {});
  const auto aligned = evaluate_rpe(w.reference, elsewhere, with(Alignment::kSe3), {});
  ASSERT_TRUE(here && there && aligned);
  EXPECT_EQ(here->samples.size(), w.reference.size() - 1);
  EXPECT_NEAR(there->statistics.rmse, here->statistics.rmse, 1e-10);
  EXPECT_NEAR(aligned->statistics.rmse, here->statistics.rmse, 1e-10);
}

TEST(Rpe, SeesAKnownDrift) {
  Trajectory reference;
  Trajectory estimate;
  for (int i = 0; i < 50; ++i) {
    reference.push_back({0.1 * i, from_xyz_rpy(0.10 * i, 0, 0, 0, 0, 0)});
    estimate.push_back({0.1 * i, from_xyz_rpy(0.11 * i, 0, 0, 0, 0, 0)});
  }
  const auto result = evaluate_rpe(reference, estimate, {}, {5.0, DeltaUnit::kFrames, true});
  ASSERT_TRUE(result) << result.problem;
  EXPECT_NEAR(result->statistics.min, 0.05, 1e-12);
  EXPECT_NEAR(result->statistics.max, 0.05, 1e-12);
}

TEST(Rpe, ExplainsABadDelta) {
  const Walks w = walks(7);
  const auto problem = [&](double delta, DeltaUnit unit) {
    return evaluate_rpe(w.reference, w.estimate, {}, {delta, unit, false}).problem;
  };
  EXPECT_THAT(problem(0.0, DeltaUnit::kMeters), HasSubstr("above 0"));
  EXPECT_THAT(problem(-1.0, DeltaUnit::kFrames), HasSubstr("above 0"));
  EXPECT_THAT(problem(1.5, DeltaUnit::kFrames), HasSubstr("whole number"));
  EXPECT_THAT(problem(181.0, DeltaUnit::kDegrees), HasSubstr("180"));
  EXPECT_THAT(problem(1e6, DeltaUnit::kMeters), HasSubstr("smaller --delta"));
  EXPECT_THAT(problem(1e300, DeltaUnit::kFrames), HasSubstr("smaller --delta"));
}

TEST(Statistics, OfAHandfulOfNumbers) {
  const Statistics s = compute_statistics({4.0, 1.0, 3.0, 2.0});
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.sse, 30.0);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(1.25));
  EXPECT_DOUBLE_EQ(s.min, 1.0);
  EXPECT_DOUBLE_EQ(s.max, 4.0);
  EXPECT_EQ(compute_statistics({}).count, 0u);
}

}  // namespace
}  // namespace fusion_slam
