#include "libs/evaluation/plot/error_plot.hpp"

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "libs/evaluation/number_rows.hpp"
#include "libs/evaluation/plot/axes.hpp"
#include "libs/evaluation/plot/color_scale.hpp"
#include "tests/libs/evaluation/made_up.hpp"

namespace fusion_slam {
namespace {

std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += text + " ";
  return all;
}

TEST(Ticks, AreRoundNumbersWithEnoughDecimals) {
  EXPECT_EQ(joined(tick_labels(ticks({0.0, 1.0}, 5))), "0.0 0.2 0.4 0.6 0.8 1.0 ");
  EXPECT_EQ(joined(tick_labels(ticks({-7.0, 12.0}, 4))), "-5 0 5 10 ");
  EXPECT_EQ(joined(tick_labels(ticks({0.0, 0.034}, 4))), "0.00 0.01 0.02 0.03 ");
  EXPECT_EQ(joined(tick_labels(ticks({0.0, 1061.0}, 6))), "0 200 400 600 800 1000 ");
  EXPECT_NEAR(rounded_out({0.0, 0.0347}, 10).high, 0.035, 1e-12);
}

TEST(Axes, EqualScaleKeepsSquaresSquare) {
  const Axes axes = Axes::with_equal_scale({100, 50, 800, 400}, {0.0, 1.0}, {0.0, 10.0});
  const cv::Point2d origin = axes.at(0.0, 0.0);
  EXPECT_NEAR(axes.at(1.0, 0.0).x - origin.x, origin.y - axes.at(0.0, 1.0).y, 1e-9);
  EXPECT_NEAR(axes.at(0.0, 10.0).y, 50.0, 1e-9);
  EXPECT_NEAR(origin.y, 450.0, 1e-9);
}

double brightness(const Color& bgr) { return 0.114 * bgr[0] + 0.587 * bgr[1] + 0.299 * bgr[2]; }

TEST(ColorScale, GrowsDarkerWithTheErrorEvenWithoutColour) {
  const ColorScale scale({0.0, 2.0});
  for (int i = 0; i < 20; ++i) {
    EXPECT_GT(brightness(scale(0.1 * i)), brightness(scale(0.1 * (i + 1))));
  }
  EXPECT_EQ(scale(-1.0), scale(0.0));
  EXPECT_EQ(scale(3.0), scale(2.0));
}

int pixels_of(const cv::Mat& image, const cv::Scalar& color) {
  cv::Mat mask;
  cv::inRange(image, color, color, mask);
  return cv::countNonZero(mask);
}

struct Scene {
  Trajectory reference;
  Trajectory estimate;
};

Scene scene() {
  std::mt19937 random(1);
  Scene s;
  s.reference = random_walk(random, 300);
  s.estimate = with_noise(random, s.reference, 0.03, 0.02);
  return s;
}

cv::Mat plot_of(const Scene& s, const EvaluationOptions& options) {
  const auto result = evaluate_ape(s.reference, s.estimate, options);
  EXPECT_TRUE(result) << result.problem;
  return draw_error_plot({*result, s.reference, s.estimate, {"title", "facts", "error", "m"}});
}

TEST(ErrorPlot, IsDrawnAndTheSameEachTime) {
  const cv::Mat first = plot_of(scene(), {});
  EXPECT_EQ(first.size(), cv::Size(1400, 1240));
  EXPECT_EQ(first.type(), CV_8UC3);
  const int white = pixels_of(first, cv::Scalar::all(255));
  EXPECT_GT(white, first.rows * first.cols / 2);
  EXPECT_LT(white, first.rows * first.cols - 20000);
  EXPECT_EQ(cv::norm(first, plot_of(scene(), {}), cv::NORM_INF), 0.0);
}

TEST(ErrorPlot, MarksTimesWithoutAnEstimate) {
  Scene s = scene();
  const Color gap = colors::kGap;
  EXPECT_LT(pixels_of(plot_of(s, {}), gap), 10);
  s.estimate.erase(s.estimate.begin() + 100, s.estimate.begin() + 200);
  EXPECT_GT(pixels_of(plot_of(s, {}), gap), 50000);
}

TEST(ErrorPlot, SurvivesASinglePoseAndNoError) {
  const Scene s{{{1.0, SE3::Identity()}}, {{1.0, SE3::Identity()}}};
  EXPECT_EQ(plot_of(s, {}).size(), cv::Size(1400, 1240));
}

TEST(ErrorPlot, WritesAPngAndSaysWhenItCannot) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("error_plot_test_" + std::to_string(::getpid()) + ".png");
  const cv::Mat image = plot_of(scene(), {});
  write_png(file, image);
  EXPECT_EQ(cv::norm(cv::imread(file.string()), image, cv::NORM_INF), 0.0);
  std::filesystem::remove(file);
  EXPECT_THROW(write_png("/nowhere/at/all.png", image), FileError);
}

}  // namespace
}  // namespace fusion_slam
