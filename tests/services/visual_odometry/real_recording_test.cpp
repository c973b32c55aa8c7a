#include <gtest/gtest.h>

#include "libs/datasets/rgbd_dataset.hpp"
#include "services/visual_odometry/visual_odometry.hpp"
#include "tests/services/visual_odometry/rendered_wall.hpp"
#include "tests/support/recordings.hpp"

namespace fusion_slam {
namespace {

std::vector<TrackingResult> track_first(const RgbdDataset& dataset, std::size_t n) {
  VisualOdometry odometry(dataset.camera, robot_with(SE3::Identity()));
  std::vector<TrackingResult> results;
  for (std::size_t i = 0; i < std::min(n, dataset.entries.size()); ++i) {
    std::string why;
    const auto frame = load_frame(dataset, i, &why);
    EXPECT_TRUE(frame) << why;
    if (frame) results.push_back(odometry.track(*frame));
  }
  return results;
}

// Motion from the first frame to the last, estimated against the reference.
double drift_m(const RgbdDataset& dataset, const std::vector<TrackingResult>& results) {
  const auto reference_at = [&](std::int64_t utime_us) {
    const ReferencePose* best = &dataset.reference.front();
    for (const ReferencePose& pose : dataset.reference)
      if (std::abs(pose.utime_us - utime_us) < std::abs(best->utime_us - utime_us)) best = &pose;
    return best->T_world_reference;
  };
  const SE3 estimated = results.front().T_odom_base.inverse() * results.back().T_odom_base;
  const SE3 real =
      reference_at(results.front().utime_us).inverse() * reference_at(results.back().utime_us);
  return (real.inverse() * estimated).translation().norm();
}

TEST(RealRecording, SevenScenesIsTrackedAndReproducible) {
  FS_RECORDING(path, "rgbd/7scenes-redkitchen");
  const RgbdDataset dataset = open_seven_scenes(path);
  const auto results = track_first(dataset, 60);
  for (const TrackingResult& result : results) EXPECT_EQ(result.state, TrackingState::kOk);
  EXPECT_LT(drift_m(dataset, results), 0.06);
  const auto again = track_first(dataset, 20);
  for (std::size_t i = 0; i < again.size(); ++i)
    EXPECT_EQ(again[i].T_odom_base.matrix(), results[i].T_odom_base.matrix());
}

TEST(RealRecording, TumDeskIsTracked) {
  FS_RECORDING(path, "rgbd/tum-fr1-desk-9");
  const RgbdDataset dataset = open_tum_rgbd(path);
  const auto results = track_first(dataset, 9);
  ASSERT_GE(results.size(), 8U);
  for (const TrackingResult& result : results) EXPECT_EQ(result.state, TrackingState::kOk);
  EXPECT_LT(drift_m(dataset, results), 0.03);
}

}  // namespace
}  // namespace fusion_slam
