#include "libs/evaluation/relations.hpp"

#include <sstream>

#include <gmock/gmock.h>
#include <zlib.h>

#include "tests/libs/evaluation/made_up.hpp"
#include "tests/support/recordings.hpp"

namespace fusion_slam {
namespace {

using ::testing::HasSubstr;

Trajectory straight_walk() {
  Trajectory walk;
  for (int i = 0; i <= 100; ++i) walk.push_back({0.2 * i, from_xyz_rpy(0.1 * i, 0, 0, 0, 0, 0)});
  return walk;
}

TEST(PoseAt, InterpolatesTakesTheNearestAndRefuses) {
  const Trajectory walk = {{1.0, from_xyz_rpy(1, 0, 0, 0, 0, 0)},
                           {2.0, from_xyz_rpy(2, 0, 0, 0, 0, 1)},
                           {2.0, from_xyz_rpy(9, 0, 0, 0, 0, 1)},
                           {5.0, from_xyz_rpy(5, 0, 0, 0, 0, 1)}};
  const auto x_at = [&](double time_s, const RelationsOptions& options) {
    const auto T = pose_at(walk, time_s, options);
    return T ? T->translation().x() : -1.0;
  };
  RelationsOptions options;
  EXPECT_NEAR(x_at(1.25, options), 1.25, 1e-12);
  EXPECT_NEAR(to_se2(*pose_at(walk, 1.25, options)).yaw, 0.25, 1e-12);
  EXPECT_EQ(x_at(1.0, options), 1.0);
  EXPECT_EQ(x_at(2.0, options), 2.0);
  EXPECT_EQ(x_at(5.0, options), 5.0);
  EXPECT_EQ(x_at(3.0, options), -1.0);  // neighbours 3 s apart
  EXPECT_EQ(x_at(0.9, options), -1.0);
  EXPECT_EQ(x_at(5.1, options), -1.0);
  EXPECT_FALSE(pose_at({}, 1.0, options));
  options.nearest = true;
  EXPECT_EQ(x_at(1.25, options), 1.0);
  EXPECT_EQ(x_at(1.75, options), 2.0);
  EXPECT_EQ(x_at(3.0, options), -1.0);
  options.max_gap_s = 3.0;
  EXPECT_EQ(x_at(4.9, options), 5.0);
}

TEST(Relations, KnownErrorsAndTheOffset) {
  const std::vector<PoseRelation> relations = {
      {101.0, 103.0, from_xyz_rpy(1.0, 0, 0, 0, 0, 0)},             // exact
      {101.0, 105.0, from_xyz_rpy(2.1, 0, 0, 0, 0, 0)},             // 0.1 m
      {103.0, 101.0, from_xyz_rpy(-1.0, 0, 0, 0, 0, M_PI / 18.0)},  // 10 degrees, backwards in time
      {150.0, 151.0, SE3::Identity()},                              // not driven
  };
  RelationsOptions options;
  options.time_offset_s = 100.0;
  const auto result = evaluate_relations(relations, straight_walk(), options);
  ASSERT_TRUE(result) << result.problem;
  EXPECT_EQ(result->usable, 3u);
  EXPECT_EQ(result->total, 4u);
  EXPECT_DOUBLE_EQ(result->usable_percent(), 75.0);
  EXPECT_NEAR(result->translation_m.max, 0.1, 1e-9);
  EXPECT_NEAR(result->translation_m.mean, 0.1 / 3.0, 1e-9);
  EXPECT_NEAR(result->rotation_deg.max, 10.0, 1e-9);
  EXPECT_NEAR(result->rotation_deg.mean, 10.0 / 3.0, 1e-9);
}

TEST(Relations, DoNotDependOnTheFrame) {
  std::mt19937 random(1);
  const Trajectory walk = random_walk(random, 100);
  std::vector<PoseRelation> relations;
  for (std::size_t i = 0; i + 7 < walk.size(); i += 3) {
    const SE3 T_1_2 = walk[i].T_world_body.inverse() * walk[i + 7].T_world_body;
    relations.push_back({walk[i].time_s, walk[i + 7].time_s, T_1_2});
  }
  const auto result = evaluate_relations(relations, moved(random_pose(random, 9, 2), walk), {});
  ASSERT_TRUE(result) << result.problem;
  EXPECT_NEAR(result->translation_m.max, 0.0, 1e-12);
  EXPECT_EQ(result->usable, relations.size());
}

TEST(Relations, SaysWhichTimesDoNotMeet) {
  const auto result = evaluate_relations({{101.0, 103.0, SE3::Identity()}}, straight_walk(), {});
  EXPECT_THAT(result.problem, HasSubstr("they span 101.000 s to 103.000 s"));
  EXPECT_THAT(result.problem, HasSubstr("--time-offset"));
}

TEST(Relations, FileErrorsNameTheLine) {
  std::istringstream in("1 2 0.5 0 0 0 0 0.1\n1 2 0.5 0 0 0 0\n");
  try {
    read_relations(in, "lab.relations");
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("lab.relations:2: "));
    EXPECT_THAT(error.what(), HasSubstr("roll pitch yaw"));
  }
}

// FLASER lines of a CARMEN log: count, ranges, laser x y yaw, odometry x y yaw, time, host, time.
Trajectory read_carmen_laser_poses(const std::filesystem::path& file) {
  Trajectory trajectory;
  gzFile log = gzopen(file.c_str(), "rb");
  std::string buffer(1 << 16, '\0');
  while (log != nullptr && gzgets(log, buffer.data(), static_cast<int>(buffer.size())) != nullptr) {
    std::istringstream line(buffer.c_str());
    std::string word;
    std::size_t count = 0;
    if (!(line >> word) || word != "FLASER" || !(line >> count)) continue;
    for (std::size_t i = 0; i < count; ++i) line >> word;
    double x = 0.0, y = 0.0, yaw = 0.0, time_s = 0.0;
    line >> x >> y >> yaw >> word >> word >> word >> time_s;
    trajectory.push_back({time_s, from_xyz_rpy(x, y, 0.0, 0.0, 0.0, yaw)});
  }
  if (log != nullptr) gzclose(log);
  return trajectory;
}

// The published log's own corrected poses against the human-verified relations; the numbers are
// those that another program found (SOURCE.txt beside the recording).
TEST(Relations, CorrectedPosesOfBuilding079) {
  FS_RECORDING(folder, "lidar/fr079");
  const Trajectory estimate = read_carmen_laser_poses(folder / "freiburg-079-corrected.log.gz");
  ASSERT_EQ(estimate.size(), 4791u);
  RelationsOptions options;
  options.time_offset_s = 1211.36;
  const auto result =
      evaluate_relations(read_relations(folder / "fr079.relations"), estimate, options);
  ASSERT_TRUE(result) << result.problem;
  EXPECT_EQ(result->usable, 1685u);
  EXPECT_EQ(result->total, 1685u);
  EXPECT_NEAR(result->translation_m.mean, 0.050, 0.0005);
  EXPECT_NEAR(result->translation_m.median, 0.042, 0.0005);
  EXPECT_NEAR(result->rotation_deg.mean, 1.63, 0.005);

  // The same poses, scan by scan: half the rotation error was the jitter between the two clocks.
  options.nearest = true;
  options.time_offset_s = 1211.42;
  const auto nearest =
      evaluate_relations(read_relations(folder / "fr079.relations"), estimate, options);
  ASSERT_TRUE(nearest) << nearest.problem;
  EXPECT_EQ(nearest->usable, 1685u);
  EXPECT_NEAR(nearest->translation_m.mean, 0.0581, 0.0001);
  EXPECT_NEAR(nearest->rotation_deg.mean, 0.711, 0.001);
  std::printf(
      "fr079 corrected poses: translation %.4f +- %.4f m (median %.4f), rotation %.3f +- %.3f "
      "deg\n",
      result->translation_m.mean, result->translation_m.std, result->translation_m.median,
      result->rotation_deg.mean, result->rotation_deg.std);
}

}  // namespace
}  // namespace fusion_slam
