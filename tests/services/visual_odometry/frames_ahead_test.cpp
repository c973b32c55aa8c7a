#include "services/visual_odometry/frames_ahead.hpp"

#include <future>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace fusion_slam {
namespace {

CameraModel camera() {
  CameraModel model;
  model.width_px = 320;
  model.height_px = 240;
  model.fx_px = model.fy_px = 260.0;
  model.cx_px = 160.0;
  model.cy_px = 120.0;
  return model;
}

RgbdFrame textured(std::int64_t utime_us) {
  std::mt19937 random(static_cast<unsigned>(utime_us));
  RgbdFrame frame;
  frame.utime_us = utime_us;
  frame.colour_bgr.create(240, 320, CV_8UC3);
  for (int i = 0; i < 240 * 320 * 3; ++i)
    frame.colour_bgr.data[i] = static_cast<std::uint8_t>(random());
  cv::GaussianBlur(frame.colour_bgr, frame.colour_bgr, cv::Size(0, 0), 2.0);
  frame.depth_mm = cv::Mat(240, 320, CV_16UC1, cv::Scalar(2000));
  return frame;
}

TEST(FramesAhead, FindsWhatIsFoundWithoutIt) {
  FramesAhead ahead(camera(), {});
  for (int utime_us = 1; utime_us <= 3; ++utime_us)
    ahead.begin(utime_us, [utime_us] { return textured(utime_us); });
  int ready = 0;
  for (int utime_us = 1; utime_us <= 3; ++utime_us) {
    const std::optional<SeenFrame> seen = ahead.take(utime_us);
    if (!seen) continue;  // not begun by then: the caller would do it
    ++ready;
    const FeatureSet slow = find_features(OrbExtractor(), camera(), textured(utime_us));
    ASSERT_EQ(seen->features.size(), slow.size());
    EXPECT_EQ(seen->features.descriptors, slow.descriptors);
    EXPECT_EQ(seen->frame.utime_us, utime_us);
    for (std::size_t i = 0; i < slow.size(); ++i) {
      EXPECT_EQ(seen->features.features[i].u_px, slow.features[i].u_px);
      EXPECT_EQ(seen->features.features[i].depth_m, slow.features[i].depth_m);
    }
  }
  std::promise<void> begun;
  ahead.begin(9, [&begun] {
    begun.set_value();
    return textured(9);
  });
  begun.get_future().wait();
  EXPECT_TRUE(ahead.take(9)) << "a frame at work is waited for";
  EXPECT_FALSE(ahead.take(9)) << "taken";
}

TEST(FramesAhead, WhatItCannotDoIsLeftToTheCaller) {
  FramesAhead ahead(camera(), {});
  const auto takes = [&](std::int64_t utime_us, const FramesAhead::Decode& decode) {
    std::promise<void> begun;
    ahead.begin(utime_us, [&] {
      begun.set_value();
      return decode();
    });
    begun.get_future().wait();
    return ahead.take(utime_us).has_value();
  };
  EXPECT_FALSE(ahead.take(1));
  EXPECT_FALSE(takes(2, [] { return std::optional<RgbdFrame>(); }));
  EXPECT_FALSE(takes(3, [] { return RgbdFrame{}; }));
  EXPECT_FALSE(takes(4, []() -> std::optional<RgbdFrame> { throw std::runtime_error("no"); }));
  EXPECT_TRUE(takes(5, [] { return textured(5); }));
}

TEST(FramesAhead, StopsWithFramesWaiting) {
  FramesAhead ahead(camera(), {});
  for (int i = 0; i < 20; ++i) ahead.begin(i, [i] { return textured(i); });
}

}  // namespace
}  // namespace fusion_slam
