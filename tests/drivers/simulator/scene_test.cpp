#include "drivers/simulator/scene.hpp"

#include <gtest/gtest.h>

#include "drivers/simulator/random.hpp"
#include "drivers/simulator/surface.hpp"

namespace fusion_slam {
namespace {

Eigen::Vector3d random_vector(Random* random, double size) {
  return {random->uniform(-size, size), random->uniform(-size, size), random->uniform(-size, size)};
}

std::vector<Box> random_boxes(Random* random, int n) {
  std::vector<Box> boxes;
  for (int i = 0; i < n; ++i) {
    Box box;
    box.T_world_box.translation() = random_vector(random, 2.0);
    box.T_world_box.linear() = exp_so3(random_vector(random, 2.0));
    box.half_m = random_vector(random, 0.6).cwiseAbs() + Eigen::Vector3d::Constant(0.02);
    boxes.push_back(box);
  }
  return boxes;
}

// Which box a point is in, by marching along the ray.
double march(const std::vector<Box>& boxes, const Eigen::Vector3d& origin,
             const Eigen::Vector3d& direction, double step, double end) {
  for (double t = step; t < end; t += step)
    for (const Box& box : boxes) {
      const Eigen::Vector3d p = box.T_world_box.inverse() * (origin + t * direction);
      if ((p.cwiseAbs().array() <= box.half_m.array()).all()) return t;
    }
  return end;
}

TEST(Scene, CastFindsWhatMarchingFinds) {
  Random random(3);
  int hits = 0;
  for (int i = 0; i < 60; ++i) {
    const Scene scene(random_boxes(&random, 16));
    const Eigen::Vector3d origin(4.0, random.uniform(-1, 1), random.uniform(-1, 1));
    const Eigen::Vector3d direction = (random_vector(&random, 1.0) - origin).normalized();
    const double step = 0.002;
    const double marched = march(scene.boxes(), origin, direction, step, 10.0);
    const auto hit = scene.cast(origin, direction);
    if (!hit) {
      EXPECT_EQ(marched, 10.0);
      continue;
    }
    ++hits;
    // Marching may step across a corner, never find something earlier.
    EXPECT_LE(hit->t, marched + 1e-9);
    const Eigen::Vector3d inside = origin + (hit->t + 1e-7) * direction;
    const Box& box = scene.boxes()[static_cast<std::size_t>(hit->box)];
    const Eigen::Vector3d local = box.T_world_box.inverse() * inside;
    EXPECT_TRUE((local.cwiseAbs().array() <= box.half_m.array() + 1e-6).all());
    if (marched - hit->t > step) {
      const double again =
          march(scene.boxes(), origin + (hit->t - 1e-4) * direction, direction, 1e-6, 2.1e-4);
      EXPECT_LT(again, 2.1e-4) << "the crossing is shorter than a step";
    }
    EXPECT_LT(scene.normal(*hit).dot(direction), 0.0);
    EXPECT_NEAR(std::fabs(local[hit->face / 2]), box.half_m[hit->face / 2], 1e-6);
  }
  EXPECT_GT(hits, 20);
}

TEST(Scene, RaysAlongAxesAndFromInside) {
  Box box;
  box.half_m = {1, 1, 1};
  const Scene scene({box});
  const auto hit = scene.cast({-3, 0.5, 0.5}, {2, 0, 0});
  ASSERT_TRUE(hit);
  EXPECT_DOUBLE_EQ(hit->t, 1.0);
  EXPECT_EQ(hit->face, 0);
  EXPECT_FALSE(scene.cast({-3, 1.5, 0}, {1, 0, 0}));
  EXPECT_FALSE(scene.cast({-3, 0, 0}, {-1, 0, 0}));
  EXPECT_FALSE(scene.cast({0, 0, 0}, {1, 0, 0}));
  EXPECT_FALSE(scene.cast({-3, 0, 0}, {1, 0, 0}, 1.9));
}

TEST(Surface, PicturesAreNotMirrored) {
  Box box;
  box.half_m = {0.5, 1.0, 1.5};
  for (int face = 0; face < 6; ++face) {
    const FaceAxes axes = face_axes(box, face);
    // Right, down and into the picture are a right-handed frame, as a camera's.
    EXPECT_TRUE(axes.s.cross(axes.t).isApprox(-face_normal(face))) << face;
    if (face < 4) {
      EXPECT_TRUE(axes.t.isApprox(-Eigen::Vector3d::UnitZ())) << face;
    }
    const Eigen::Vector3d end = axes.corner + axes.width_m * axes.s + axes.height_m * axes.t;
    EXPECT_TRUE(axes.corner.cwiseAbs().isApprox(box.half_m));
    EXPECT_TRUE(end.cwiseAbs().isApprox(box.half_m));
    EXPECT_DOUBLE_EQ(end[face / 2], axes.corner[face / 2]);
  }
}

TEST(Random, GaussianHasItsMoments) {
  Random random(7);
  double sum = 0, squares = 0;
  const int n = 100000;
  for (int i = 0; i < n; ++i) {
    const double x = random.gaussian();
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / n, 0.0, 0.015);
  EXPECT_NEAR(squares / n, 1.0, 0.02);
}

}  // namespace
}  // namespace fusion_slam
