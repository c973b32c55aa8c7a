#include "drivers/simulator/world.hpp"

#include <gmock/gmock.h>

#include "drivers/simulator/texture.hpp"
#include "libs/config/yaml_map.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

std::string error_of(const std::string& text) {
  try {
    world_from_text(text, "w.yaml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

TEST(World, ErrorsNameFileLineAndKey) {
  const std::string route = "route: [[0, 0], [1, 0]]\n";
  EXPECT_EQ(error_of(route), "no error");
  EXPECT_EQ(error_of(route + "thinks: []\n"),
            "w.yaml:2: unknown key 'thinks'; the nearest valid key is 'things'");
  EXPECT_EQ(error_of(route + "things:\n  - {kind: chair, at: [1, 2], yaw_degr: 3}\n"),
            "w.yaml:3: unknown key 'yaw_degr'; the nearest valid key is 'yaw_deg'");
  EXPECT_THAT(error_of(route + "things:\n  - {kind: chiar, at: [1, 2]}\n"),
              HasSubstr("w.yaml:3: 'kind' is 'chiar'; the nearest valid value is 'chair'"));
  EXPECT_THAT(error_of(route + "things:\n  - {kind: box, at: [1, 2]}\n"),
              HasSubstr("'size_m' is missing"));
  EXPECT_THAT(error_of(route + "things:\n  - {kind: box, at: [1], size_m: [1, 1, 1]}\n"),
              HasSubstr("'at' must be a list of 2 or 3 numbers"));
  EXPECT_THAT(error_of(route + "walls:\n  - {from: [0, 0], to: [1, x]}\n"),
              HasSubstr("w.yaml:3: 'to'"));
  EXPECT_THAT(error_of(route + "walls:\n  - {from: [1, 1], to: [1, 1]}\n"),
              HasSubstr("w.yaml:3: the wall ends where it begins"));
  EXPECT_THAT(error_of(route + "things:\n  - {kind: desk, at: [1, 2], size_m: [1, 0.7, 0.02]}\n"),
              HasSubstr("w.yaml:3: 'size_m' is too small for a desk"));
  EXPECT_THAT(error_of(route + "limits: {speed_m_s: 90}\n"), HasSubstr("'speed_m_s' must be"));
  EXPECT_THAT(error_of("name: x\n"), HasSubstr("'route' needs"));
  EXPECT_THAT(error_of("route: [[0, 0"), HasSubstr("not valid YAML"));
  EXPECT_THAT(error_of("7"), HasSubstr("w.yaml:1:"));
}

TEST(World, WallStandsBetweenItsEnds) {
  const World world = world_from_text(
      "route: [[0, 0], [1, 0]]\nwalls: [{from: [1, 1], to: [1, 4], thickness_m: 0.2, height_m: 2}]",
      "w");
  ASSERT_EQ(world.boxes.size(), 1U);
  const Eigen::Vector3d end = world.boxes[0].T_world_box * world.boxes[0].half_m;
  EXPECT_TRUE(end.isApprox(Eigen::Vector3d(0.9, 4.0, 2.0)));
}

TEST(Texture, EveryKindHasDetailAtEveryScale) {
  for (const std::string& name : texture_names()) {
    Material material{*texture_from(name), default_colour(*texture_from(name)), 5};
    const Texture texture(material, 0, 1.0, 1.0);
    for (const float step : {0.003F, 0.02F, 0.1F}) {
      double change = 0;
      for (int i = 0; i < 2000; ++i) {
        const float s = 0.05F + 0.0137F * static_cast<float>(i % 60);
        const float t = 0.05F + 0.0253F * static_cast<float>(i / 60);
        change += std::fabs(texture.at(s, t)[1] - texture.at(s + step, t)[1]);
      }
      EXPECT_GT(change / 2000 * 255, 0.4) << name << " at " << step;
    }
  }
}

}  // namespace
}  // namespace fusion_slam
