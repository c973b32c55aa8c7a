#include "libs/features/feature_grid.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TEST(FeatureGrid, FindsWhatASearchThroughAllFinds) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> u(-5.0F, 325.0F);  // a little outside too
  std::vector<Feature> features(400);
  for (Feature& f : features) {
    f.u_px = u(random);
    f.v_px = u(random) * 0.75F;
    f.octave = static_cast<std::int8_t>(random() % 8);
  }
  const FeatureGrid grid(features, 320, 240);
  for (int query = 0; query < 200; ++query) {
    const double x = u(random);
    const double y = u(random) * 0.75;
    const double radius = 1.0 + random() % 40;
    const int low = static_cast<int>(random() % 4);
    std::vector<int> expected;
    for (int i = 0; i < static_cast<int>(features.size()); ++i)
      if (std::hypot(features[i].u_px - x, features[i].v_px - y) <= radius &&
          features[i].octave >= low && features[i].octave <= low + 3)
        expected.push_back(i);
    std::vector<int> found;
    grid.near(x, y, radius, low, low + 3, &found);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }
}

}  // namespace
}  // namespace fusion_slam
