#include "libs/report/top_view.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TEST(TopView, WaysAndLinksAreWhereTheirMetresSay) {
  TopView view{"t", std::nullopt, {{"way", "plain", {{0, 0}, {1.0, 0}}, {}}}, {}, 0.0};
  view.links.push_back({{0, 0}, {1.0, 0}, "closure", "a < b"});
  const std::string svg = top_view_svg(view);
  // 1.8 m by 0.8 m with margins: 740 / 1.8 = 411.1 pixels a metre; y 0 is 0.4 m below the top.
  EXPECT_NE(svg.find("<path d=\"M174.4 218.4L174.4 218.4L585.6 218.4\"/>"), std::string::npos)
      << svg;
  EXPECT_NE(svg.find("class=\"closure\" d=\"M174.4 218.4L585.6 218.4\""), std::string::npos) << svg;
  EXPECT_NE(svg.find("a &lt; b"), std::string::npos);
}

TEST(TopView, ErrorsColourTheWay) {
  const TopView view{
      "t", std::nullopt, {{"w", "way", {{0, 0}, {0.5, 0}, {1, 0}}, {0.0, 0.0, 0.2}}}, {}, 0.0};
  const std::string svg = top_view_svg(view);
  EXPECT_NE(svg.find("0.200 m"), std::string::npos);
  EXPECT_NE(svg.find("\" stroke=\"#"), std::string::npos);
}

TEST(TopView, JumpsAndWhatIsNoNumberAreNotDrawn) {
  const TopView view{"t",
                     std::nullopt,
                     {{"w", "plain", {{0, 0}, {0.5, 0}, {NAN, 0}, {9, 0}, {9.5, 0}}, {}}},
                     {},
                     0.0};
  const std::string svg = top_view_svg(view);
  std::size_t paths = 0;
  for (std::size_t at = svg.find("<path d=\"M"); at != std::string::npos;
       at = svg.find("<path d=\"M", at + 1))
    ++paths;
  EXPECT_EQ(paths, 3U) << svg;  // two pieces and the legend
}

TEST(TopView, NothingIsSaid) {
  EXPECT_NE(top_view_svg({"map", std::nullopt, {}, {}, 0.0}).find("nothing to show"),
            std::string::npos);
  const TopView infinite{"map", std::nullopt, {{"w", "plain", {{INFINITY, 0}}, {}}}, {}, 0.0};
  EXPECT_NE(top_view_svg(infinite).find("nothing to show"), std::string::npos);
}

}  // namespace
}  // namespace fusion_slam
