// What the LiDAR gives vision: depth and motion; and what the graph gives.
#include <gtest/gtest.h>

#include "services/visual_odometry/graph_revision.hpp"
#include "services/visual_odometry/lidar_depth.hpp"
#include "services/visual_odometry/lidar_motion.hpp"
#include "tests/services/visual_odometry/made_up_map.hpp"

namespace fusion_slam {
namespace {

// LiDAR at 0.2 m, camera at 0.35 m, both looking along base x.
RobotModel two_sensors() {
  RobotModel robot;
  robot.has_lidar = robot.has_camera = true;
  robot.T_base_lidar = from_xyz_rpy(0.05, 0.0, 0.2, 0, 0, 0.3);
  robot.T_base_camera = SE3::Identity();
  robot.T_base_camera.linear() = optical_to_body();
  robot.T_base_camera.translation() = Eigen::Vector3d(0.1, 0.0, 0.35);
  return robot;
}

// Of the wall x = wall_m of base.
LaserScan scan_of_wall(const RobotModel& robot, double wall_m) {
  LaserScan scan;
  scan.radstep = 2 * M_PI / 360;
  for (int i = 0; i < 360; ++i) {
    const double angle = i * scan.radstep + 0.3;
    const double range = (wall_m - robot.T_base_lidar.translation().x()) / std::cos(angle);
    scan.ranges_m.push_back(range > 0 && range < 12.0 ? static_cast<float>(range) : 0.0F);
  }
  return scan;
}

Feature feature_at(const CameraModel& camera, const RobotModel& robot,
                   const Eigen::Vector3d& p_base, double depth_error_m, bool depth) {
  const Eigen::Vector3d p = robot.T_base_camera.inverse() * p_base;
  Feature f;
  f.u_px = static_cast<float>(camera.project(p).x());
  f.v_px = static_cast<float>(camera.project(p).y());
  if (depth) {
    f.depth_m = static_cast<float>(p.z() + depth_error_m);
    f.depth_sigma_m = static_cast<float>(camera.depth_sigma(p.z()));
  }
  return f;
}

TEST(LidarDepth, TheBetterOfTwoDepthsWins) {
  const CameraModel camera;
  const RobotModel robot = two_sensors();
  const double wall_m = 5.0;  // the camera's sigma is 0.047 m there, the LiDAR's 0.02
  const ScanInBase scan = scan_at(scan_of_wall(robot, wall_m), robot, Vector6d::Zero(), 0);
  FeatureSet set;
  const double z_m = wall_m - 0.1;
  set.features = {
      feature_at(camera, robot, {wall_m, 0.5, 0.3}, 0.06, true),    // agrees, near the plane
      feature_at(camera, robot, {wall_m, -0.5, 0.21}, 0, false),    // none of its own, in the plane
      feature_at(camera, robot, {wall_m, 0.2, 0.3}, 0, false),      // none, 10 cm off the plane
      feature_at(camera, robot, {wall_m, 0.1, 0.9}, 0.06, true),    // too far from the plane
      feature_at(camera, robot, {wall_m, -0.2, 0.25}, -0.5, true),  // something in front
  };
  EXPECT_EQ(attach_lidar_depth(scan, robot, camera, {}, &set), 2);
  EXPECT_NEAR(set.features[0].depth_m, z_m, 1e-3);
  EXPECT_NEAR(set.features[0].depth_sigma_m, 0.02, 0.002);
  EXPECT_NEAR(set.features[1].depth_m, z_m, 1e-3);
  EXPECT_EQ(set.features[2].depth_m, 0.0F);
  EXPECT_NEAR(set.features[3].depth_m, z_m + 0.06, 1e-3);
  EXPECT_NEAR(set.features[4].depth_m, z_m - 0.5, 1e-3);
}

TEST(LidarDepth, NearSurfacesKeepTheCamerasDepth) {
  const CameraModel camera;
  const RobotModel robot = two_sensors();
  const ScanInBase scan = scan_at(scan_of_wall(robot, 1.5), robot, Vector6d::Zero(), 0);
  FeatureSet set;
  set.features = {feature_at(camera, robot, {1.5, 0.1, 0.2}, 0.001, true)};
  EXPECT_EQ(attach_lidar_depth(scan, robot, camera, {}, &set), 0);
}

TEST(LidarDepth, BeamsAreCarriedToTheTimeOfTheFrame) {
  RobotModel robot = two_sensors();
  robot.lidar.beam_period_s = 0.0005;
  Vector6d twist = Vector6d::Zero();
  twist(0) = 0.4;  // m/s ahead
  LaserScan scan = scan_of_wall(robot, 3.0);
  const ScanInBase points = scan_at(scan, robot, twist, 100'000);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(points[i].allFinite(), scan.ranges_m[i] > 0.0F);
    if (!points[i].allFinite()) continue;
    const double dt_s = 0.1 - static_cast<double>(i) * 0.0005;
    EXPECT_NEAR(points[i].x(), 3.0 - 0.4 * dt_s, 1e-5);
  }
}

TEST(LidarMotion, InterpolatesCarriesOnAndKnowsItsLimits) {
  LidarMotion motion;
  EXPECT_FALSE(motion.between(0, 1));
  const auto at = [](double t_s) { return from_xyz_rpy(0.5 * t_s, 0, 0, 0, 0, 0.2 * t_s); };
  for (int i = 0; i <= 100; ++i) motion.add(i * 100'000, at(0.1 * i));
  motion.add(5'000'000, from_xyz_rpy(9, 9, 9, 0, 0, 0));  // late: ignored
  const auto check = [&](double from_s, double to_s) {
    const auto moved = motion.between(static_cast<std::int64_t>(from_s * 1e6),
                                      static_cast<std::int64_t>(to_s * 1e6));
    ASSERT_TRUE(moved) << from_s << " " << to_s;
    EXPECT_LT(local(at(from_s).inverse() * at(to_s), *moved).norm(), 2e-3);
  };
  check(9.0, 9.55);
  check(9.95, 10.05);
  EXPECT_FALSE(motion.between(9'900'000, 10'500'000));  // too far beyond
  EXPECT_FALSE(motion.between(1'000'000, 9'900'000));   // forgotten: only seconds are kept
}

TEST(GraphRevision, OldKeyframesFollowAndTheNewestStandsStill) {
  MadeUpMap m = make_map(16, 60, 0.0);
  const SE3 T_base_camera = two_sensors().T_base_camera;
  const VisualOdometryConfig config;
  GraphRevision revision;
  const SE3 T_map_odom = from_xyz_rpy(3, -2, 0, 0, 0, 1.0);  // whatever the map frame is
  const auto say = [&](const SE3& bend, int first, int last) {
    for (int k = first; k <= last; ++k)
      revision.update(k, T_map_odom * (k <= 4 ? bend : SE3::Identity()) * m.poses.at(k) *
                             T_base_camera.inverse());
  };
  say(SE3::Identity(), 1, 16);
  EXPECT_TRUE(revision.take_up(16, T_base_camera, config, &m.map).keyframes.empty());
  const VisualMap before = m.map;
  say(from_xyz_rpy(0.005, 0, 0, 0, 0, 0), 1, 16);  // the graph's own noise
  EXPECT_TRUE(revision.take_up(16, T_base_camera, config, &m.map).keyframes.empty());
  const SE3 bend = from_xyz_rpy(0.1, 0.05, 0, 0, 0, 0.05);  // a closure moved the oldest ones
  say(bend, 1, 16);
  EXPECT_EQ(revision.take_up(16, T_base_camera, config, &m.map).keyframes.size(), 4U);
  for (const auto& [id, keyframe] : m.map.keyframes()) {
    const SE3 expected = (id <= 4 ? bend : SE3::Identity()) * m.poses.at(id);
    EXPECT_LT(local(expected, keyframe.T_odom_camera).norm(), 1e-6) << id;
  }
  // What keyframe 5 and newer see has not moved; the old ones have all that they saw, where they
  // are now.
  EXPECT_TRUE(consistent(m.map));
  for (const auto& [id, keyframe] : m.map.keyframes()) {
    const std::vector<std::int64_t>& saw = before.keyframe(id)->landmark_of_feature;
    for (std::size_t i = 0; i < saw.size(); ++i) {
      ASSERT_NE(keyframe.landmark_of_feature[i], 0);
      const Eigen::Vector3d was = before.landmark(saw[i])->p_odom;
      const Landmark& now = *m.map.landmark(keyframe.landmark_of_feature[i]);
      EXPECT_LT((now.p_odom - (id <= 4 ? bend * was : was)).norm(), 1e-6) << id;
      EXPECT_EQ(now.descriptor, keyframe.features->descriptors[i]);
    }
  }
  EXPECT_TRUE(revision.take_up(16, T_base_camera, config, &m.map).keyframes.empty());  // once
}

}  // namespace
}  // namespace fusion_slam
