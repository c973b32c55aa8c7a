#include "libs/datasets/maebot.hpp"

#include <cmath>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "libs/eventlog/writer.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kTime = 1'422'065'468'000'000;

struct Encoder {
  std::vector<std::uint8_t> bytes;
  Encoder& number(std::uint64_t value, int n) {
    for (int i = n - 1; i >= 0; --i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    return *this;
  }
  Encoder& real(float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, 4);
    return number(bits, 4);
  }
};

std::vector<std::uint8_t> sweep_bytes(std::int64_t utime, const std::vector<float>& ranges,
                                      const std::vector<float>& thetas) {
  Encoder e;
  e.number(0x89dc5b879a5056cf, 8)
      .number(static_cast<std::uint64_t>(utime), 8)
      .number(ranges.size(), 4);
  for (const float r : ranges) e.real(r);
  for (const float t : thetas) e.real(t);
  for (std::size_t i = 0; i < ranges.size(); ++i)
    e.number(static_cast<std::uint64_t>(utime) + 500 * i, 8);
  for (std::size_t i = 0; i < ranges.size(); ++i) e.real(0.5F);
  return e.bytes;
}

std::vector<std::uint8_t> pose_bytes(std::int64_t utime, float x, float y, float theta) {
  Encoder e;
  e.number(0x1f317af1246276ac, 8)
      .number(static_cast<std::uint64_t>(utime), 8)
      .real(x)
      .real(y)
      .real(theta);
  return e.bytes;
}

std::vector<std::uint8_t> ticks_bytes(std::int64_t utime, std::int32_t left, std::int32_t right) {
  Encoder e;
  e.number(0x8dc5a028fca42ff9, 8).number(static_cast<std::uint64_t>(utime), 8);
  e.number(static_cast<std::uint32_t>(left), 4).number(static_cast<std::uint32_t>(right), 4);
  for (int i = 0; i < 6; ++i) e.number(0, 4);
  return e.bytes;
}

// A wall at x = 1 in front, nothing elsewhere but 2 m; angles clockwise and a little uneven, the
// first just before 0.
MaebotSweep uneven_sweep(int n) {
  MaebotSweep s;
  s.utime_us = kTime;
  for (int i = 0; i < n; ++i) {
    const double theta = 2 * M_PI * i / n + 0.004 * std::sin(1.7 * i) - 0.003;
    s.thetas_rad.push_back(static_cast<float>(theta < 0 ? theta + 2 * M_PI : theta));
    s.ranges_m.push_back(static_cast<float>(2.0 + 0.5 * std::sin(theta)));
    s.times_us.push_back(kTime + 500 * i);
    s.intensities.push_back(1.0F);
  }
  return s;
}

LogEvent event(const std::string& channel, std::vector<std::uint8_t> data) {
  LogEvent e;
  e.offset_bytes = 77;
  e.channel = channel;
  e.data = std::move(data);
  return e;
}

TEST(Maebot, GoldenEvents) {
  MaebotLog log;
  const std::vector<float> ranges(9, 1.25F);
  const std::vector<float> thetas = {6.27F, 0.69F, 1.4F, 2.1F, 2.8F, 3.5F, 4.2F, 4.9F, 5.6F};
  EXPECT_TRUE(add_maebot_event(event("L", sweep_bytes(kTime, ranges, thetas)), &log));
  EXPECT_TRUE(add_maebot_event(event("M", ticks_bytes(kTime, 5421, -4660)), &log));
  EXPECT_TRUE(add_maebot_event(event("P", pose_bytes(kTime, 1.5F, -2.5F, 7.0F)), &log));
  EXPECT_TRUE(add_maebot_event(event("OTHER", {1, 2, 3, 4, 5, 6, 7, 8}), &log));
  ASSERT_EQ(log.sweeps.size(), 1u);
  EXPECT_EQ(log.sweeps[0].ranges_m, ranges);
  EXPECT_EQ(log.sweeps[0].thetas_rad, thetas);
  EXPECT_EQ(log.sweeps[0].times_us[8], kTime + 4000);
  EXPECT_NEAR(log.beam_period_s(), 0.0005, 1e-12);
  ASSERT_EQ(log.encoders.size(), 1u);
  EXPECT_EQ(log.encoders[0].left, 5421);
  EXPECT_EQ(log.encoders[0].right, -4660);
  ASSERT_EQ(log.poses.size(), 1u);
  EXPECT_NEAR(log.poses[0].pose.yaw, 7.0 - 2 * M_PI, 1e-6);
  EXPECT_EQ(log.ignored.at("OTHER"), 1);
  EXPECT_EQ(log.events, 4);
}

TEST(Maebot, DamageIsCountedWithItsOffset) {
  MaebotLog log;
  const auto good =
      sweep_bytes(kTime, std::vector<float>(9, 1.0F), {0, 1, 2, 3, 4, 5, 6, 6.1F, 6.2F});
  for (std::size_t n = 8; n < good.size(); ++n)
    EXPECT_FALSE(add_maebot_event(
        event("L", {good.begin(), good.begin() + static_cast<std::ptrdiff_t>(n)}), &log));
  auto huge = good;
  huge[16] = 0x7F;  // two billion beams
  EXPECT_FALSE(add_maebot_event(event("L", huge), &log));
  EXPECT_FALSE(add_maebot_event(event("P", pose_bytes(139736737237464, 0, 0, 0)), &log));
  EXPECT_TRUE(log.sweeps.empty());
  EXPECT_EQ(log.skipped.reasons().at("P: time stamp was never set").first_place, 77);
}

TEST(Maebot, SweepBecomesAnEvenClockwiseGrid) {
  const MaebotSweep sweep = uneven_sweep(290);
  const LaserScan scan = to_laser_scan(sweep);
  ASSERT_EQ(scan.ranges_m.size(), 290u);
  EXPECT_EQ(scan.utime_us, kTime);
  EXPECT_NEAR(scan.radstep, -2 * M_PI / 290, 1e-12);
  EXPECT_LT(std::abs(std::remainder(scan.rad0, 2 * M_PI)), 0.01);
  for (std::size_t i = 0; i < 290; ++i) {
    // Counter-clockwise angle a is clockwise angle -a: the range there is 2 + sin(-a) / 2.
    const double angle = scan.rad0 + static_cast<double>(i) * scan.radstep;
    EXPECT_NEAR(scan.ranges_m[i], 2.0 - 0.5 * std::sin(angle), 0.002) << i;
  }
}

TEST(Maebot, GapsStayEmptyAndEdgesAreNotBlurred) {
  MaebotSweep sweep = uneven_sweep(290);
  for (std::size_t i = 0; i < 290; ++i) sweep.ranges_m[i] = i % 20 < 10 ? 1.0F : 3.0F;
  for (const float r : to_laser_scan(sweep).ranges_m) EXPECT_TRUE(r == 1.0F || r == 3.0F) << r;
  for (std::size_t i = 100; i < 200; ++i)
    sweep.thetas_rad[i] = sweep.thetas_rad[99] + 1e-4F * (static_cast<float>(i) - 99);
  const LaserScan scan = to_laser_scan(sweep);
  EXPECT_EQ(scan.ranges_m[150], 0.0F);
  EXPECT_GT(scan.ranges_m[250], 0.0F);
}

TEST(Maebot, LogsWithoutSweepsAndCutLogs) {
  const auto path =
      std::filesystem::temp_directory_path() / ("fs_maebot_" + std::to_string(getpid()) + ".lcm");
  const auto good =
      sweep_bytes(kTime, std::vector<float>(9, 1.0F), {0, 1, 2, 3, 4, 5, 6, 6.1F, 6.2F});
  {
    LogWriter writer(path);
    writer.write(1, "P", pose_bytes(kTime, 0, 0, 0));
    writer.close();
  }
  EXPECT_THROW(read_maebot(path), DatasetError);
  {
    LogWriter writer(path);
    writer.write(1, "L", good);
    writer.write(2, "P", pose_bytes(kTime, 0, 0, 0));
    writer.close();
  }
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 5);
  const MaebotLog log = read_maebot(path);
  EXPECT_EQ(log.sweeps.size(), 1u);
  EXPECT_EQ(log.skipped.total(), 1);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace fusion_slam
