// Every number of evo 1.36.5's golden file, to 1e-9 relative.
#include <cmath>
#include <fstream>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "libs/evaluation/trajectory_error.hpp"
#include "libs/evaluation/tum_file.hpp"
#include "tests/support/recordings.hpp"

namespace fusion_slam {
namespace {

constexpr double kRelative = 1e-9;
// Where evo's error is 0 but for rounding (the first pose after aligning origins: 1e-16 m, 5e-15
// deg), both must be.
constexpr double kAbsolute = 1e-12;

const std::map<std::string, Alignment> kAlignments = {{"none", Alignment::kNone},
                                                      {"origin", Alignment::kOrigin},
                                                      {"se3", Alignment::kSe3},
                                                      {"sim3", Alignment::kSim3}};

struct GoldenMetric {
  ErrorRelation relation;
  std::optional<RelativeOptions> relative;  // absolute error when not set
};

constexpr RelativeOptions kOneFrame{1.0, DeltaUnit::kFrames, false};
constexpr RelativeOptions kOneMeter{1.0, DeltaUnit::kMeters, false};
constexpr RelativeOptions kOneMeterAll{1.0, DeltaUnit::kMeters, true};
constexpr RelativeOptions kTenDegrees{10.0, DeltaUnit::kDegrees, false};

const std::map<std::string, GoldenMetric> kMetrics = {
    {"ape_translation_part_m", {ErrorRelation::kTranslation, {}}},
    {"ape_rotation_angle_deg", {ErrorRelation::kRotation, {}}},
    {"ape_full_transformation", {ErrorRelation::kFull, {}}},
    {"rpe_1frame_translation_part_m", {ErrorRelation::kTranslation, kOneFrame}},
    {"rpe_1frame_rotation_angle_deg", {ErrorRelation::kRotation, kOneFrame}},
    {"rpe_1m_translation_part_m", {ErrorRelation::kTranslation, kOneMeter}},
    {"rpe_1m_rotation_angle_deg", {ErrorRelation::kRotation, kOneMeter}},
    {"rpe_1m_all_pairs_translation_part_m", {ErrorRelation::kTranslation, kOneMeterAll}},
    {"rpe_1m_all_pairs_rotation_angle_deg", {ErrorRelation::kRotation, kOneMeterAll}},
    {"rpe_10deg_translation_part_m", {ErrorRelation::kTranslation, kTenDegrees}},
    {"rpe_10deg_rotation_angle_deg", {ErrorRelation::kRotation, kTenDegrees}},
};

TEST(Golden, EveryNumberOfEvo) {
  FS_RECORDING(folder, "trajectories");
  std::ifstream in(folder / "evo-1.36.5-golden.json");
  const nlohmann::json golden = nlohmann::json::parse(in);
  double worst = 0.0;
  std::size_t compared = 0;
  for (const nlohmann::json& entry : golden) {
    const TumFile ref = read_tum(folder / entry.at("reference").get<std::string>());
    const TumFile est = read_tum(folder / entry.at("estimate").get<std::string>());
    EXPECT_EQ(est.trajectory.size(), entry.at("estimate_poses").get<std::size_t>());
    EvaluationOptions options;
    options.alignment = kAlignments.at(entry.at("aligned"));
    options.max_diff_s = entry.at("max_diff_s");
    for (const auto& [key, expected] : entry.items()) {
      if (!expected.is_object()) continue;
      SCOPED_TRACE(entry.at("estimate").get<std::string>() + " " +
                   entry.at("aligned").get<std::string>() + " " + key);
      ASSERT_EQ(kMetrics.count(key), 1u) << "the golden file has a metric this test doesn't know";
      const GoldenMetric& metric = kMetrics.at(key);
      options.relation = metric.relation;
      const auto ours =
          metric.relative ? evaluate_rpe(ref.trajectory, est.trajectory, options, *metric.relative)
                          : evaluate_ape(ref.trajectory, est.trajectory, options);
      ASSERT_TRUE(ours) << ours.problem;
      EXPECT_EQ(ours->matched.size(), entry.at("pairs").get<std::size_t>());
      ASSERT_EQ(expected.size(), ours->statistics.named().size());
      for (const auto& [name, value] : ours->statistics.named()) {
        const double theirs = expected.at(std::string(name));
        ++compared;
        if (std::abs(theirs) < kAbsolute) {
          EXPECT_LT(value, kAbsolute) << name;
          continue;
        }
        EXPECT_NEAR(value, theirs, kRelative * theirs) << name;
        worst = std::max(worst, std::abs(value - theirs) / theirs);
      }
    }
  }
  EXPECT_EQ(compared, golden.size() * kMetrics.size() * 7);
  std::printf("%zu numbers compared, greatest relative difference %.2g\n", compared, worst);
}

}  // namespace
}  // namespace fusion_slam
