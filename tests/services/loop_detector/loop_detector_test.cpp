#include "services/loop_detector/loop_detector.hpp"

#include <gtest/gtest.h>

#include "tests/services/loop_detector/made_up_places.hpp"

namespace fusion_slam {
namespace {

const SE3 kMounting = from_xyz_rpy(0.2, 0.0, 0.3, -1.5707963, 0.0, -1.5707963);
const SE3 kSecondView = from_xyz_rpy(0.3, -0.1, 0.2, 0.1, -0.2, 0.15);

// Place 1 first, then 29 others.
void drive(LoopDetector* detector, const CameraModel& camera) {
  for (int id = 1; id <= 30; ++id)
    EXPECT_TRUE(
        detector->add(keyframe_at(id, see_place(make_place(id), camera, SE3::Identity(), id)))
            .empty());
}

TEST(LoopDetector, KnowsAPlaceAgainAndFromWhere) {
  const CameraModel camera;
  LoopDetector detector(camera, kMounting);
  drive(&detector, camera);
  const auto found =
      detector.add(keyframe_at(31, see_place(make_place(1), camera, kSecondView, 31)));
  ASSERT_EQ(found.size(), 1U);
  const LoopCandidate& loop = found[0];
  EXPECT_EQ(loop.from_id, 1);
  EXPECT_EQ(loop.to_id, 31);
  EXPECT_FALSE(loop.accepted);
  ASSERT_EQ(loop.stages.size(), 4U);
  EXPECT_EQ(loop.stages[0].stage, "appearance");
  EXPECT_TRUE(loop.stages[0].passed);
  EXPECT_GT(loop.stages[0].score, 0.3);
  EXPECT_EQ(loop.stages[1].stage, "geometry");
  EXPECT_TRUE(loop.stages[1].passed);
  EXPECT_GT(loop.stages[1].score, 100);
  for (int i : {2, 3}) {
    EXPECT_FALSE(loop.stages[i].passed);
    EXPECT_EQ(loop.stages[i].reason, "not run in this version");
  }
  const SE3 expected = kMounting * kSecondView * kMounting.inverse();
  EXPECT_LT(local(expected, loop.T_from_to).head<3>().norm(), 0.01);
  EXPECT_LT(local(expected, loop.T_from_to).tail<3>().norm(), 0.005);
}

TEST(LoopDetector, SimilarLooksInAnotherArrangementFailGeometry) {
  const CameraModel camera;
  LoopDetector detector(camera, kMounting);
  drive(&detector, camera);
  MadeUpPlace shuffled = make_place(1);
  shuffled.points = make_place(77).points;
  const auto found =
      detector.add(keyframe_at(31, see_place(shuffled, camera, SE3::Identity(), 31)));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].stages[0].passed);
  EXPECT_FALSE(found[0].stages[1].passed);
  EXPECT_FALSE(found[0].accepted);
}

TEST(LoopDetector, TheNewestKeyframesAreNoPlaces) {
  const CameraModel camera;
  LoopDetector detector(camera, kMounting);
  for (int id = 1; id <= 12; ++id)
    EXPECT_TRUE(
        detector.add(keyframe_at(id, see_place(make_place(1), camera, kSecondView, id))).empty());
}

TEST(LoopDetector, AcceptsOnVisionAloneWhenAskedTo) {
  const CameraModel camera;
  LoopDetectorConfig config;
  config.accept_without_lidar = true;
  LoopDetector detector(camera, kMounting, config);
  drive(&detector, camera);
  const auto found =
      detector.add(keyframe_at(31, see_place(make_place(1), camera, kSecondView, 31)));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].accepted);
}

TEST(LoopDetector, SaysHowFarApartTheGraphThinksTheyAre) {
  const CameraModel camera;
  LoopDetector detector(camera, kMounting);
  drive(&detector, camera);
  detector.moved(1, from_xyz_rpy(3.0, 0, 0, 0, 0, 0));
  detector.moved(30, from_xyz_rpy(0, 4.0, 0, 0, 0, 0));
  const auto found =
      detector.add(keyframe_at(31, see_place(make_place(1), camera, kSecondView, 31)));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NE(found[0].stages[1].reason.find("5.00 m apart"), std::string::npos)
      << found[0].stages[1].reason;
}

TEST(LoopDetector, RepeatedAndEmptyKeyframesDoNoHarm) {
  const CameraModel camera;
  LoopDetector detector(camera, kMounting);
  drive(&detector, camera);
  EXPECT_TRUE(
      detector.add(keyframe_at(5, see_place(make_place(1), camera, kSecondView, 5))).empty());
  EXPECT_EQ(detector.n_keyframes(), 30U);
  EXPECT_TRUE(detector.add(keyframe_at(31, {})).empty());
}

}  // namespace
}  // namespace fusion_slam
