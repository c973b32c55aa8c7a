#include "services/pose_graph/landmark_part.hpp"

#include <random>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {
namespace {

struct Scene {
  CameraModel camera;
  SE3 T_base_camera = SE3::Identity();
  Poses poses;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::vector<LandmarkView>> views;
};

// Three moving keyframes and one that stands still, in a row, seeing ten points; nothing exact.
Scene scene() {
  std::mt19937 random(3);
  std::normal_distribution<double> gauss;
  Scene s;
  s.T_base_camera = from_xyz_rpy(0.1, -0.05, 0.3, 0, 0, 0.1);
  s.T_base_camera.linear() = s.T_base_camera.linear() * optical_to_body();
  for (int i = 0; i < 3; ++i)
    s.poses.push_back(from_xyz_rpy(0.3 * i, 0.1 * i, 0.01, 0.02, 0, 0.1 * i));
  const SE3 still = from_xyz_rpy(-0.3, 0.05, 0, 0, 0.01, -0.1);
  for (int l = 0; l < 10; ++l) {
    const Eigen::Vector3d p(3.0 + 0.2 * l, 0.5 * gauss(random), 0.5 + 0.3 * gauss(random));
    std::vector<LandmarkView> views;
    for (int v = -1; v < 3; ++v) {
      if (l % 4 == v) continue;
      LandmarkView view;
      view.variable = v;
      view.T_map_base = still;
      const SE3 T = (v < 0 ? still : s.poses[static_cast<std::size_t>(v)]) * s.T_base_camera;
      const Eigen::Vector3d q = T.inverse() * p;
      view.seen.pixel = s.camera.project(q) + Eigen::Vector2d(gauss(random), gauss(random));
      view.seen.pixel_sigma = 0.7 + 0.1 * l;
      if (l % 3 != 1 || v == 0) {
        view.seen.depth_m = q.z() + 0.02 * gauss(random);
        view.seen.depth_sigma_m = 0.02;
      }
      views.push_back(view);
    }
    if (l == 7) views.back().seen.pixel.x() += 60.0;  // a wrong match
    s.points.push_back(p + 0.01 * Eigen::Vector3d(gauss(random), gauss(random), gauss(random)));
    s.views.push_back(views);
  }
  return s;
}

LandmarkPart part_of(const Scene& s) {
  LandmarkPart part(s.camera, s.T_base_camera, {});
  for (std::size_t l = 0; l < s.points.size(); ++l) part.add(s.points[l], s.views[l]);
  part.make_pattern(3);
  return part;
}

// The cost as a function of everything, told again from the definition.
double whole_cost(const Scene& s, const Poses& poses, const std::vector<Eigen::Vector3d>& points) {
  const LandmarkNoise noise;
  double sum = 0.0;
  for (std::size_t l = 0; l < points.size(); ++l)
    for (const LandmarkView& view : s.views[l]) {
      const SE3 T_map_base =
          view.variable < 0 ? view.T_map_base : poses[static_cast<std::size_t>(view.variable)];
      const Eigen::Vector3d q = (T_map_base * s.T_base_camera).inverse() * points[l];
      double chi2 = ((s.camera.project(q) - view.seen.pixel) / view.seen.pixel_sigma).squaredNorm();
      double c2 = noise.doubt_2d;
      if (view.seen.depth_m > 0.0) {
        chi2 += std::pow((q.z() - view.seen.depth_m) / view.seen.depth_sigma_m, 2);
        c2 = noise.doubt_3d;
      }
      sum += 0.5 * c2 * std::log(1.0 + chi2 / c2) / noise.optimism;
    }
  return sum;
}

TEST(LandmarkPart, CostIsTheRobustSumOfSquares) {
  const Scene s = scene();
  EXPECT_NEAR(part_of(s).cost(s.poses), whole_cost(s, s.poses, s.points), 1e-9);
}

// Where each point stands best for the poses, the reduced gradient is the slope of the whole cost
// along the poses, and it is so numerically.
TEST(LandmarkPart, GradientIsTheSlope) {
  const Scene s = scene();
  LandmarkPart part = part_of(s);
  for (int i = 0; i < 20; ++i) part.settle(s.poses);
  std::vector<Eigen::Vector3d> points;
  for (std::size_t l = 0; l < part.n_landmarks(); ++l) points.push_back(part.point(l));
  part.linearise(s.poses);
  for (std::size_t v = 0; v < 3; ++v)
    for (int k = 0; k < 6; ++k) {
      Vector6d xi = Vector6d::Zero();
      const double h = 1e-6;
      Poses plus = s.poses, minus = s.poses;
      xi[k] = h;
      plus[v] = retract(plus[v], xi);
      xi[k] = -h;
      minus[v] = retract(minus[v], xi);
      const double slope = (whole_cost(s, plus, points) - whole_cost(s, minus, points)) / (2.0 * h);
      EXPECT_NEAR(part.gradient()[v][k], slope, 1e-4 * std::max(1.0, std::abs(slope))) << v << k;
    }
}

// The same step as from the whole equations, poses and points at once, with numeric derivatives.
TEST(LandmarkPart, EliminationGivesTheStepOfTheWholeSystem) {
  const Scene s = scene();
  const LandmarkNoise noise;
  const int n = 18 + 3 * static_cast<int>(s.points.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(n);
  for (std::size_t l = 0; l < s.points.size(); ++l)
    for (const LandmarkView& view : s.views[l]) {
      const auto residual = [&](const Eigen::VectorXd& x) {
        SE3 T = view.T_map_base;
        if (view.variable >= 0)
          T = retract(s.poses[static_cast<std::size_t>(view.variable)],
                      x.segment<6>(6 * view.variable));
        const Eigen::Vector3d q = (T * s.T_base_camera).inverse() *
                                  (s.points[l] + x.segment<3>(18 + 3 * static_cast<int>(l)));
        Eigen::Vector3d r;
        r << (s.camera.project(q) - view.seen.pixel) / view.seen.pixel_sigma,
            view.seen.depth_m > 0.0 ? (q.z() - view.seen.depth_m) / view.seen.depth_sigma_m : 0.0;
        return r;
      };
      const Eigen::Vector3d r = residual(Eigen::VectorXd::Zero(n));
      Eigen::MatrixXd J(3, n);
      for (int k = 0; k < n; ++k) {
        Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
        x[k] = 1e-6;
        J.col(k) = (residual(x) - residual(-x)) / 2e-6;
      }
      const double c2 = view.seen.depth_m > 0.0 ? noise.doubt_3d : noise.doubt_2d;
      const double w = 1.0 / (1.0 + r.squaredNorm() / c2) / noise.optimism;
      H += w * J.transpose() * J;
      g += w * J.transpose() * r;
    }
  const Eigen::VectorXd slow = H.ldlt().solve(-g);

  LandmarkPart part = part_of(s);
  part.linearise(s.poses);
  Eigen::MatrixXd reduced = Eigen::MatrixXd::Zero(18, 18);
  Eigen::VectorXd gradient(18);
  for (std::size_t i = 0; i < part.pairs().size(); ++i) {
    const auto [a, b] = part.pairs()[i];
    reduced.block<6, 6>(6 * a, 6 * b) = part.blocks()[i];
    reduced.block<6, 6>(6 * b, 6 * a) = part.blocks()[i].transpose();
  }
  std::vector<Vector6d> steps(3);
  for (int v = 0; v < 3; ++v)
    gradient.segment<6>(6 * v) = part.gradient()[static_cast<std::size_t>(v)];
  const Eigen::VectorXd fast = reduced.ldlt().solve(-gradient);
  EXPECT_LT((fast - slow.head<18>()).norm(), 1e-4 * slow.head<18>().norm());
  for (int v = 0; v < 3; ++v) steps[static_cast<std::size_t>(v)] = fast.segment<6>(6 * v);
  part.step(steps);
  for (std::size_t l = 0; l < s.points.size(); ++l)
    EXPECT_LT((part.point(l) - s.points[l] - slow.segment<3>(18 + 3 * static_cast<int>(l))).norm(),
              1e-4)
        << l;
  part.drop();
  EXPECT_EQ(part.point(3), s.points[3]);
}

TEST(LandmarkPart, APointBehindTheCameraPullsNothing) {
  Scene s = scene();
  for (LandmarkView& view : s.views[0]) view.seen.depth_m = 1.0;
  s.points[0] = {-5.0, 0.0, 0.0};
  LandmarkPart part = part_of(s);
  part.linearise(s.poses);
  for (const Vector6d& g : part.gradient()) EXPECT_TRUE(g.allFinite());
  EXPECT_GT(part.n_doubted(s.poses), 2);
}

}  // namespace
}  // namespace fusion_slam
