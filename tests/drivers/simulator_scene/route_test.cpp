#include "drivers/simulator/route.hpp"

#include <gmock/gmock.h>

namespace fusion_slam {
namespace {

using testing::HasSubstr;

std::string error_of(const std::string& text) {
  try {
    route_from_text(text, "r.yaml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Route, ShippedRouteIsThePeersDrive) {
  const Route route = load_route(std::string(FS_SOURCE_DIR) + "/config/routes/small-house.yaml");
  double length_m = 0.0;
  for (std::size_t i = 1; i < route.way_points_m.size(); ++i)
    length_m += (route.way_points_m[i] - route.way_points_m[i - 1]).norm();
  EXPECT_NEAR(length_m, 51.0, 0.1);  // 47.4 m when driven: it cuts corners
  ASSERT_TRUE(route.camera && route.seconds);
  EXPECT_EQ(route.camera->fx_px, 570.0);
  EXPECT_EQ(route.camera->cx_px, 319.5);
  EXPECT_EQ(route.camera->z_m, 0.35);
  EXPECT_EQ(route.noise.at("colour_sigma").value, 2.5);
  EXPECT_EQ(route.without.count("motion-blur"), 1U);
}

TEST(Route, ReadsWhatIsGivenAndKeepsDefaults) {
  const Route route = route_from_text(
      "route: [[0, 0], [1, 2]]\nlimits: {turn_rad_s: 1.5}\ncamera: {fx: 300, width: 320, height: "
      "240, "
      "pitch_deg: 10}\nnoise:\n  slip: 0.5\n",
      "r.yaml");
  EXPECT_EQ(route.way_points_m[1], Eigen::Vector2d(1, 2));
  EXPECT_EQ(route.limits.max_turn_rad_s, 1.5);
  EXPECT_EQ(route.limits.max_speed_m_s, 0.5);
  EXPECT_EQ(route.camera->fy_px, 300.0);
  EXPECT_EQ(route.camera->cx_px, 159.5);
  EXPECT_NEAR(route.camera->pitch_rad, 0.1745, 1e-4);
  EXPECT_EQ(route.noise.at("slip").place, "r.yaml:5");
  EXPECT_FALSE(route.seconds);
}

TEST(Route, ErrorsNameFileLineAndKey) {
  EXPECT_THAT(error_of("name: x\n"), HasSubstr("'route' is missing"));
  EXPECT_THAT(error_of("route: [[0, 0]]\n"), HasSubstr("two or more way points"));
  EXPECT_EQ(error_of("route: [[0, 0], [1, 0]]\nlimit: {}\n"),
            "r.yaml:2: unknown key 'limit'; the nearest valid key is 'limits'");
  EXPECT_THAT(error_of("route: [[0, 0], [1, 0]]\ncamera: {fx: 1}\n"), HasSubstr("r.yaml:2: 'fx'"));
  EXPECT_THAT(error_of("route: [[0, 0], [1, 0]]\nnoise: {a: b}\n"), HasSubstr("r.yaml:2: 'noise'"));
  EXPECT_THAT(error_of("route: ["), HasSubstr("not valid YAML"));
}

}  // namespace
}  // namespace fusion_slam
