#include "libs/evaluation/alignment.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/libs/evaluation/made_up.hpp"

namespace fusion_slam {
namespace {

using Points = std::vector<Eigen::Vector3d>;

double cost(const Similarity& S, const Points& from, const Points& to) {
  double sum = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) sum += (to[i] - S * from[i]).squaredNorm();
  return sum;
}

// The obvious, slow way: coordinate descent with shrinking steps over 7 parameters, from several
// starts.
Similarity search(const Points& from, const Points& to, bool with_scale) {
  std::mt19937 random(5);
  Similarity best;
  for (int start = 0; start < 12; ++start) {
    Similarity S;
    S.T_to_from = random_pose(random, 1.0, start == 0 ? 0.0 : M_PI);
    double step = 1.0;
    while (step > 1e-9) {
      bool better = false;
      for (int axis = 0; axis < (with_scale ? 14 : 12); ++axis) {
        Similarity next = S;
        const double change = axis % 2 == 0 ? step : -step;
        if (axis < 12) {
          Vector6d xi = Vector6d::Zero();
          xi(axis / 2) = change;
          next.T_to_from.linear() = exp_so3(xi.tail<3>()) * S.T_to_from.linear();
          next.T_to_from.translation() += xi.head<3>();
        } else {
          next.scale *= std::exp(change);
        }
        if (cost(next, from, to) >= cost(S, from, to)) continue;
        S = next;
        better = true;
      }
      if (!better) step *= 0.5;
    }
    if (cost(S, from, to) < cost(best, from, to)) best = S;
  }
  return best;
}

Points cloud(std::mt19937& random, std::size_t count, const Eigen::Vector3d& extent) {
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    // Centred away from the origin only a little, so that the oracle's coordinates are not badly
    // coupled.
    points.push_back(random_vector(random, 1.0).cwiseProduct(extent) +
                     Eigen::Vector3d(0.1, -0.2, 0.3));
  }
  return points;
}

Points changed(std::mt19937& random, const Similarity& S, const Points& from, double noise_m) {
  Points to;
  for (const Eigen::Vector3d& p : from) to.push_back(S * p + random_vector(random, noise_m));
  return to;
}

TEST(Umeyama, RecoversAnExactSimilarity) {
  std::mt19937 random(1);
  for (int i = 0; i < 50; ++i) {
    const Similarity truth{std::exp(random_vector(random, 1.0).x()),
                           random_pose(random, 20.0, 2.0)};
    const Points from = cloud(random, 3 + i, {1.0, 2.0, 3.0});
    const auto S = umeyama(from, changed(random, truth, from, 0.0), true);
    ASSERT_TRUE(S) << S.problem;
    EXPECT_NEAR(S->scale, truth.scale, 1e-12 * truth.scale);
    EXPECT_TRUE(S->T_to_from.isApprox(truth.T_to_from, 1e-12));
  }
}

TEST(Umeyama, IsAsGoodAsASlowSearch) {
  std::mt19937 random(2);
  for (const bool with_scale : {false, true}) {
    for (int i = 0; i < 4; ++i) {
      const Similarity truth{with_scale ? 1.7 : 1.0, random_pose(random, 1.0, 2.0)};
      const Points from = cloud(random, 12, {1.0, 1.5, 0.5});
      const Points to = changed(random, truth, from, 0.2);
      const auto S = umeyama(from, to, with_scale);
      ASSERT_TRUE(S) << S.problem;
      const Similarity found = search(from, to, with_scale);
      EXPECT_LE(cost(*S, from, to), cost(found, from, to) + 1e-12);
      EXPECT_NEAR(cost(*S, from, to), cost(found, from, to), 1e-6);
      EXPECT_TRUE(S->T_to_from.isApprox(found.T_to_from, 1e-3));
    }
  }
}

TEST(Umeyama, NeverReflects) {
  std::mt19937 random(3);
  const Points from = cloud(random, 20, {1.0, 2.0, 0.3});
  Points mirrored = from;
  for (Eigen::Vector3d& p : mirrored) p.z() = -p.z();
  const auto S = umeyama(from, mirrored, false);
  ASSERT_TRUE(S) << S.problem;
  EXPECT_NEAR(S->T_to_from.linear().determinant(), 1.0, 1e-12);
  EXPECT_LE(cost(*S, from, mirrored), cost(search(from, mirrored, false), from, mirrored) + 1e-12);
}

TEST(Umeyama, AlignsAFlatTrajectory) {
  std::mt19937 random(4);
  const Points from = cloud(random, 30, {5.0, 5.0, 0.0});
  const Similarity truth{1.0, random_pose(random, 3.0, 1.0)};
  const auto S = umeyama(from, changed(random, truth, from, 0.0), false);
  ASSERT_TRUE(S) << S.problem;
  EXPECT_TRUE(S->T_to_from.isApprox(truth.T_to_from, 1e-9));
}

TEST(Umeyama, RefusesWhatDeterminesNoRotation) {
  const Points two = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_NE(umeyama(two, two, false).problem.find("at least 3"), std::string::npos);
  Points line;
  for (int i = 0; i < 10; ++i) line.emplace_back(0.3 * i, 0.1 * i, -0.7 * i);
  EXPECT_NE(umeyama(line, line, false).problem.find("one line"), std::string::npos);
  const Points spot(10, Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(umeyama(spot, spot, true));
}

TEST(FindAlignment, OriginMakesTheFirstPosesCoincide) {
  std::mt19937 random(6);
  MatchedPoses matched;
  matched.reference = random_walk(random, 10);
  matched.estimate = moved(random_pose(random, 5.0, 2.0), matched.reference);
  const auto S = find_alignment(matched, Alignment::kOrigin);
  ASSERT_TRUE(S);
  const Trajectory aligned = transform(*S, matched.estimate);
  for (std::size_t i = 0; i < aligned.size(); ++i) {
    EXPECT_TRUE(aligned[i].T_world_body.isApprox(matched.reference[i].T_world_body, 1e-12));
  }
}

}  // namespace
}  // namespace fusion_slam
