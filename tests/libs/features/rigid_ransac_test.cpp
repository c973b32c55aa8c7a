#include "libs/features/rigid_ransac.hpp"

#include <gtest/gtest.h>

#include "tests/libs/features/made_up_matches.hpp"

namespace fusion_slam {
namespace {

const SE3 kPose = from_xyz_rpy(-0.6, 0.4, 0.2, 0.5, -0.3, 1.2);

TEST(RigidRansac, FindsThePoseAmongSeventyPercentWrong) {
  const CameraModel camera;
  std::mt19937 random(11);
  const auto matches = made_up_matches(camera, kPose, 200, 140, 0.5, &random);
  const auto found = find_pose(camera, matches);
  ASSERT_TRUE(found);
  const Vector6d error = local(kPose, found->T_reference_camera);
  EXPECT_LT(error.head<3>().norm(), 0.05);
  EXPECT_LT(error.tail<3>().norm(), 0.03);
  EXPECT_GT(found->inliers.size(), 30U);
}

TEST(RigidRansac, SameMatchesSameAnswer) {
  const CameraModel camera;
  std::mt19937 random(12);
  const auto matches = made_up_matches(camera, kPose, 100, 50, 1.0, &random);
  const auto first = find_pose(camera, matches);
  const auto second = find_pose(camera, matches);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->T_reference_camera.matrix(), second->T_reference_camera.matrix());
  EXPECT_EQ(first->inliers, second->inliers);
}

TEST(RigidRansac, NothingInNoise) {
  const CameraModel camera;
  std::mt19937 random(13);
  EXPECT_FALSE(find_pose(camera, made_up_matches(camera, kPose, 150, 150, 1.0, &random)));
}

TEST(RigidRansac, NothingWithoutDepthOrFromOnePoint) {
  const CameraModel camera;
  std::mt19937 random(14);
  auto matches = made_up_matches(camera, kPose, 50, 0, 0.0, &random);
  for (Correspondence& m : matches) m.depth_m = 0.0;
  EXPECT_FALSE(find_pose(camera, matches));
  EXPECT_FALSE(find_pose(camera, {}));
  const auto one = made_up_matches(camera, kPose, 2, 0, 0.0, &random);
  EXPECT_FALSE(find_pose(camera, std::vector<Correspondence>(40, one[1])));
}

}  // namespace
}  // namespace fusion_slam
