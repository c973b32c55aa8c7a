// The geometry stage measures where the newer camera stood, says how well, and uses no feature
// twice.
#include "libs/places/geometry_check.hpp"

#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

constexpr double kScale = 1.2;  // of the pyramid

struct Scene {
  std::vector<Eigen::Vector3d> points;  // seen from the older camera
  std::vector<Descriptor> descriptors;
};

Descriptor random_bits(std::mt19937& random) {
  Descriptor d;
  for (auto& word : d) word = (static_cast<std::uint64_t>(random()) << 32U) | random();
  return d;
}

// n points in a box around `middle` with these half sides.
Scene scene(const Eigen::Vector3d& middle, const Eigen::Vector3d& half, int n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  Scene s;
  for (int i = 0; i < n; ++i) {
    const double x = u(random), y = u(random), z = u(random);
    s.points.emplace_back(middle + half.cwiseProduct(Eigen::Vector3d(x, y, z)));
    s.descriptors.push_back(random_bits(random));
  }
  return s;
}

// What a camera there sees: half a pixel of noise, the depth camera's noise, a few bits flipped,
// the octave that the distance asks for.
FeatureSet seen(const Scene& s, const CameraModel& camera, const SE3& T_older_camera,
                unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  FeatureSet set;
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    const Eigen::Vector3d p = T_older_camera.inverse() * s.points[i];
    if (p.z() < 0.4) continue;
    const Eigen::Vector2d pixel = camera.project(p);
    const double du = normal(random), dv = normal(random), dz = normal(random);
    if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > 639 || pixel.y() > 479) continue;
    Feature f;
    const double octave = 3.0 + std::log(s.points[i].norm() / p.norm()) / std::log(kScale);
    f.octave = static_cast<std::int8_t>(std::lround(octave));
    f.u_px = static_cast<float>(pixel.x() + 0.5 * du);
    f.v_px = static_cast<float>(pixel.y() + 0.5 * dv);
    f.depth_m = static_cast<float>(p.z() + camera.depth_sigma(p.z()) * dz);
    set.features.push_back(f);
    Descriptor d = s.descriptors[i];
    for (int k = 0; k < 15; ++k) {
      const unsigned bit = random() % 256;
      d[bit / 64] ^= 1ULL << (bit % 64);
    }
    set.descriptors.push_back(d);
  }
  return set;
}

const SE3 kMoved = from_xyz_rpy(0.15, 0.05, 0.4, 0.02, 0.1, 0.03);

TEST(GeometryCheck, MeasuresTheMotionAndSaysHowWell) {
  const CameraModel camera;
  const GeometryConfig config;
  const Scene room = scene({0, 0, 2.5}, {1.2, 0.9, 1.0}, 300, 1);
  const GeometryCheck check = check_geometry(camera, seen(room, camera, SE3::Identity(), 2),
                                             seen(room, camera, kMoved, 3), config);
  EXPECT_GT(check.n_inliers, 150);
  EXPECT_TRUE(is_precise(check, config));
  const Vector6d error = local(kMoved, check.T_older_newer);
  EXPECT_LT(error.head<3>().norm(), 3.0 * check.sigma_m);
  EXPECT_LT(error.tail<3>().norm(), 3.0 * check.sigma_rad);
  EXPECT_LT(error.head<3>().norm(), 0.01);
}

// Forty features on a picture at the far end of a hall: which place it is, but not where in it.
TEST(GeometryCheck, AFewFeaturesFarAwayAreVague) {
  const CameraModel camera;
  const GeometryConfig config;
  const Scene picture = scene({0.4, 0.3, 6.5}, {0.35, 0.25, 0.01}, 40, 4);
  const GeometryCheck check = check_geometry(camera, seen(picture, camera, SE3::Identity(), 5),
                                             seen(picture, camera, kMoved, 6), config);
  EXPECT_GE(check.n_inliers, config.min_inliers);
  EXPECT_FALSE(is_precise(check, config));
  EXPECT_GT(check.sigma_m, config.most_sigma_m);
}

// A texture whose points all look like their neighbours: however many newer features lie near an
// older one, they are one match.
TEST(GeometryCheck, NoFeatureIsUsedTwice) {
  const CameraModel camera;
  const GeometryConfig config;
  const Scene room = scene({0, 0, 2.5}, {1.2, 0.9, 1.0}, 200, 7);
  Scene with_twins = room;
  for (std::size_t i = 0; i < room.points.size(); ++i) {
    with_twins.points.emplace_back(room.points[i] + Eigen::Vector3d(0.006, 0.004, 0.0));
    with_twins.descriptors.push_back(room.descriptors[i]);
  }
  const GeometryCheck check = check_geometry(camera, seen(room, camera, SE3::Identity(), 8),
                                             seen(with_twins, camera, kMoved, 9), config);
  std::set<int> older, newer;
  for (const auto& [a, b] : check.same) {
    EXPECT_TRUE(older.insert(a).second) << "older feature " << a;
    EXPECT_TRUE(newer.insert(b).second) << "newer feature " << b;
  }
  EXPECT_LE(check.n_inliers, 200);
  EXPECT_EQ(check.n_inliers, static_cast<int>(check.same.size()));
}

// The same look at another size is another thing.
TEST(GeometryCheck, GuidedMatchesHaveTheSizeThatTheDistanceSays) {
  const CameraModel camera;
  const GeometryConfig config;
  const Scene room = scene({0, 0, 2.5}, {1.2, 0.9, 1.0}, 200, 10);
  const FeatureSet older = seen(room, camera, SE3::Identity(), 11);
  FeatureSet newer = seen(room, camera, kMoved, 12);
  std::set<int> wrong;
  for (std::size_t i = 0; i < newer.size(); i += 3) {
    newer.features[i].octave = static_cast<std::int8_t>(newer.features[i].octave + 4);
    wrong.insert(static_cast<int>(i));
  }
  const GeometryCheck check = check_geometry(camera, older, newer, config);
  EXPECT_GT(check.n_inliers, 80);
  for (const auto& [a, b] : check.same) EXPECT_EQ(wrong.count(b), 0U);
}

}  // namespace
}  // namespace fusion_slam
