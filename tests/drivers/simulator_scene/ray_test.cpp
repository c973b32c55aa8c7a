// Embree's answers against slow, obvious ones.
#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "drivers/simulator/camera_renderer.hpp"
#include "drivers/simulator/mesh_shapes.hpp"
#include "drivers/simulator/random.hpp"
#include "drivers/simulator/scene.hpp"

namespace fusion_slam {
namespace {

Eigen::Vector3d random_vector(Random* random, double size) {
  return {random->uniform(-size, size), random->uniform(-size, size), random->uniform(-size, size)};
}

// Entry of a ray into a box, both in the box's frame: slab method (Kay & Kajiya 1986).
std::optional<std::pair<double, int>> enter_box(const Eigen::Vector3d& half,
                                                const Eigen::Vector3d& origin,
                                                const Eigen::Vector3d& direction) {
  double enter = 0.0, leave = std::numeric_limits<double>::infinity();
  int face = -1;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = (-half[axis] - origin[axis]) / direction[axis];
    const double high = (half[axis] - origin[axis]) / direction[axis];
    if (std::min(low, high) > enter) {
      enter = std::min(low, high);
      face = 2 * axis + (direction[axis] < 0.0 ? 1 : 0);
    }
    leave = std::min(leave, std::max(low, high));
  }
  if (face < 0 || enter > leave) return std::nullopt;
  return std::pair(enter, face);
}

// Moeller & Trumbore 1997, both sides.
std::optional<double> meet_triangle(const std::array<Eigen::Vector3d, 3>& p,
                                    const Eigen::Vector3d& origin,
                                    const Eigen::Vector3d& direction) {
  const Eigen::Vector3d a = p[1] - p[0], b = p[2] - p[0], h = direction.cross(b);
  const double det = a.dot(h);
  if (std::fabs(det) < 1e-14) return std::nullopt;
  const Eigen::Vector3d s = origin - p[0], q = s.cross(a);
  const double u = s.dot(h) / det, v = direction.dot(q) / det, t = b.dot(q) / det;
  if (u < 0.0 || v < 0.0 || u + v > 1.0 || t <= 0.0) return std::nullopt;
  return t;
}

struct Things {
  std::vector<Box> boxes;
  std::vector<Mesh> meshes;
};

Things random_things(Random* random) {
  Things things;
  for (int i = 0; i < 14; ++i) {
    SE3 T;
    T.translation() = random_vector(random, 2.0);
    T.linear() = exp_so3(random_vector(random, 2.0));
    const Eigen::Vector3d half =
        random_vector(random, 0.6).cwiseAbs() + Eigen::Vector3d::Constant(0.02);
    if (i % 2 == 0) {
      Box box;
      box.T_world_box = T;
      box.half_m = half;
      things.boxes.push_back(box);
    } else {
      things.meshes.push_back(placed(i % 4 == 1 ? sphere_mesh(0.5) : box_mesh(2.0 * half), T));
    }
  }
  return things;
}

struct Answer {
  double t = std::numeric_limits<double>::infinity();
  int box = -1, face = 0, mesh = -1;
};

Answer obvious(const Things& things, const Eigen::Vector3d& origin,
               const Eigen::Vector3d& direction) {
  Answer best;
  for (std::size_t i = 0; i < things.boxes.size(); ++i) {
    const SE3 T_box_world = things.boxes[i].T_world_box.inverse();
    const auto hit =
        enter_box(things.boxes[i].half_m, T_box_world * origin, T_box_world.linear() * direction);
    if (hit && hit->first < best.t) best = {hit->first, static_cast<int>(i), hit->second, -1};
  }
  for (std::size_t i = 0; i < things.meshes.size(); ++i)
    for (const auto& c : things.meshes[i].triangles) {
      const auto& v = things.meshes[i].vertices_m;
      const auto t =
          meet_triangle({v[c[0]].cast<double>(), v[c[1]].cast<double>(), v[c[2]].cast<double>()},
                        origin, direction);
      if (t && *t < best.t) best = {*t, -1, 0, static_cast<int>(i)};
    }
  return best;
}

TEST(Rays, SingleOnesMeetWhatTheObviousWayMeets) {
  Random random(3);
  int boxes = 0, meshes = 0;
  for (int i = 0; i < 12; ++i) {
    const Things things = random_things(&random);
    const Scene scene(things.boxes, things.meshes);
    for (int k = 0; k < 60; ++k) {
      // Now and then from within things.
      const Eigen::Vector3d origin = random_vector(&random, k % 3 == 0 ? 1.5 : 5.0);
      const Eigen::Vector3d direction = random_vector(&random, 1.5) - origin;
      const Answer answer = obvious(things, origin, direction);
      const auto hit = scene.cast(origin, direction);
      ASSERT_EQ(hit.has_value(), std::isfinite(answer.t));
      EXPECT_EQ(scene.blocked(origin, direction), hit.has_value());
      if (!hit) continue;
      ASSERT_NEAR(hit->t, answer.t, 1e-6 * (1.0 + answer.t));
      EXPECT_EQ(hit->box, answer.box);
      EXPECT_EQ(hit->mesh, answer.mesh);
      EXPECT_FALSE(scene.cast(origin, direction, 0.99 * answer.t));
      if (hit->box >= 0) {
        EXPECT_EQ(hit->face, answer.face);
        EXPECT_NEAR(hit->t, answer.t, 1e-12 * (1.0 + answer.t)) << "exact for boxes";
        ++boxes;
      } else {
        ++meshes;
      }
    }
  }
  EXPECT_GT(boxes, 150);
  EXPECT_GT(meshes, 150);
}

TEST(Rays, PacketsMeetWhatSingleOnesMeet) {
  Random random(4);
  int differ = 0, n = 0;
  for (int i = 0; i < 12; ++i) {
    const Things things = random_things(&random);
    const Scene scene(things.boxes, things.meshes);
    const Eigen::Vector3d origin = random_vector(&random, i % 2 == 0 ? 1.0 : 4.0);
    for (int k = 0; k < 50; ++k) {
      RayPacket rays;
      const Eigen::Vector3d towards = random_vector(&random, 1.5) - origin;
      for (std::size_t j = 0; j < 8; ++j) {
        const Eigen::Vector3d d = towards + random_vector(&random, 0.02);
        rays.x[j] = static_cast<float>(d.x());
        rays.y[j] = static_cast<float>(d.y());
        rays.z[j] = static_cast<float>(d.z());
      }
      scene.cast(origin.cast<float>(), scene.within_a_box(origin), 0.0F, &rays);
      for (std::size_t j = 0; j < 8; ++j, ++n) {
        const Eigen::Vector3d d(rays.x[j], rays.y[j], rays.z[j]);
        const auto hit = scene.cast(origin.cast<float>().cast<double>(), d);
        if (hit.has_value() != (rays.geometry[j] >= 0) ||
            (hit && std::fabs(hit->t - static_cast<double>(rays.t[j])) > 1e-4)) {
          ++differ;  // grazes an edge
          continue;
        }
        if (!hit) continue;
        EXPECT_EQ(rays.geometry[j], hit->mesh + 1);
        EXPECT_EQ(rays.primitive[j], hit->mesh < 0 ? hit->box * 6 + hit->face : hit->triangle);
        EXPECT_NEAR(static_cast<double>(rays.cosine[j]),
                    std::fabs(scene.normal(*hit).dot(d.normalized())), 1e-4);
      }
    }
  }
  EXPECT_LE(differ, n / 1000);
}

TEST(Rays, NothingIsNothing) {
  const Scene scene({});
  EXPECT_FALSE(scene.cast({0, 0, 0}, {1, 0, 0}));
  EXPECT_FALSE(scene.blocked({0, 0, 0}, {1, 0, 0}));
}

// A mesh looks the same from every thread, alone or beside other frames.
TEST(CameraRenderer, MeshesAreRenderedTheSameWhateverCameBefore) {
  Mesh ball = placed(sphere_mesh(0.5), from_xyz_rpy(0, 0, 2, 0, 0, 0));
  ball.bgr = {0.2F, 0.5F, 0.9F};
  Lighting lighting;
  lighting.lamps_m = {{2, -2, 0}};
  lighting.background_bgr = {10, 20, 30};
  const Scene scene({}, {ball});
  CameraModel camera;
  camera.width_px = 66;  // no multiple of a packet
  camera.height_px = 49;
  camera.fx_px = camera.fy_px = 60.0;
  camera.cx_px = 32.5;
  camera.cy_px = 24.0;
  const CameraRenderer one(scene, lighting, camera), two(scene, lighting, camera);
  const SE3 ahead = SE3::Identity();
  two.prepare({from_xyz_rpy(0.3, 0, 0, 0, 0, 0), ahead, from_xyz_rpy(0, 0.2, 0, 0, 0, 0)}, 3);
  const RenderedFrame a = one.render(ahead), b = two.render(ahead);
  EXPECT_EQ(cv::norm(a.colour_bgr, b.colour_bgr, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(a.depth_m, b.depth_m, cv::NORM_INF), 0.0);
  EXPECT_NEAR(a.depth_m(24, 32), 1.5, 0.01);
  EXPECT_EQ(a.depth_m(2, 2), 0.0F);
  EXPECT_EQ(a.surface(24, 32), 0);
  EXPECT_EQ(a.surface(2, 2), -1);
  EXPECT_EQ(a.colour_bgr(2, 2), cv::Vec3f(10, 20, 30));
  EXPECT_GT(a.colour_bgr(24, 32)[2], 3.0F * a.colour_bgr(24, 32)[0]);
}

}  // namespace
}  // namespace fusion_slam
