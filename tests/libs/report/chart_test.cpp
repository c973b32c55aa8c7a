#include "libs/report/chart.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(Chart, PointsAreWhereTheirNumbersSay) {
  const std::string svg = line_chart_svg({"t", "s", "m", {{"a", {{0, 0}, {5, 1}, {10, 2}}}}});
  // Plot area: 58 ... 746 by 42 ... 220 pixels; y from 0 to 2.
  EXPECT_NE(svg.find("d=\"M58.0 220.0L402.0 131.0L746.0 42.0\""), std::string::npos) << svg;
  EXPECT_EQ(count(svg, "class=\"key\""), 0U);
}

TEST(Chart, BreaksWhereNothingWasAndWhereNoNumberIs) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 20; ++i) points.emplace_back(i < 10 ? i : i + 50, 1.0);
  points[5].y() = NAN;
  const std::string svg = line_chart_svg({"t", "s", "m", {{"a", points}}});
  EXPECT_EQ(count(svg, "M"), 3U) << svg;
  LineChart whole{"t", "s", "m", {{"a", points}}, false};
  EXPECT_EQ(count(line_chart_svg(whole), "M"), 2U);
}

TEST(Chart, ThinningKeepsTheExtremes) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 100'000; ++i) points.emplace_back(i, i == 77'777 ? 10.0 : 1.0);
  const std::string svg = line_chart_svg({"t", "s", "m", {{"a", points}}});
  EXPECT_LT(count(svg, "L"), 3000U);
  EXPECT_EQ(count(svg, " 42.0"), 1U);  // the one peak, at the top of the plot
}

TEST(Chart, NothingIsSaid) {
  EXPECT_NE(line_chart_svg({"errors", "s", "m", {{"a", {{NAN, NAN}}}}}).find("nothing to show"),
            std::string::npos);
  EXPECT_NE(histogram_svg({"errors", "m", {}}).find("nothing to show"), std::string::npos);
}

TEST(Chart, AConstantIsALine) {
  EXPECT_NE(line_chart_svg({"t", "s", "m", {{"a", {{3, 0}}}}}).find("M58.0 220.0"),
            std::string::npos);
}

TEST(Histogram, CountsAll) {
  std::vector<double> values;
  for (int i = 0; i < 999; ++i) values.push_back(0.001 * i);
  values.push_back(100.0);
  const std::string svg = histogram_svg({"t", "m", values});
  EXPECT_EQ(count(svg, "class=\"bar\""), 40U);
  EXPECT_NE(svg.find("larger, up to 100.000"), std::string::npos) << svg;
}

TEST(Histogram, AllZeroIsOneBar) {
  const std::string svg = histogram_svg({"t", "m", std::vector<double>(7, 0.0)});
  EXPECT_EQ(count(svg, "height=\"0.0\""), 39U) << svg;
}

}  // namespace
}  // namespace fusion_slam
