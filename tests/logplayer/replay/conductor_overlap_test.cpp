// What lockstep does at the same time: inert events with the next one, processes that stay behind.
// Neither may change what anybody sees, or in which order.
#include <algorithm>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "libs/bus/transport.hpp"
#include "logplayer/replay/conductor.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

LogEvent odometry(std::int64_t utime_us) {
  bot_core::pose_t pose{};
  pose.utime = utime_us;
  return {0, utime_us, utime_us, "ODOMETRY", bus_detail::encode(pose)};
}

LogEvent scan(std::int64_t utime_us) {
  bot_core::planar_lidar_t scan{};
  scan.utime = utime_us;
  return {0, utime_us, utime_us, "LIDAR", bus_detail::encode(scan)};
}

TEST(ConductorOverlap, InertEventsAreHandledInTheOrderOfTheLog) {
  const auto transport = std::make_shared<Transport>("memq://");
  Bus driver(named_bus("replay", Mode::kThroughput), transport);
  Bus mapper(named_bus("mapper", Mode::kLockstep), transport);
  std::vector<std::string> seen;
  mapper.subscribe<bot_core::planar_lidar_t>("LIDAR", Policy::kKeepAll,
                                             [&](const bot_core::planar_lidar_t& m) {
                                               seen.push_back("scan " + std::to_string(m.utime));
                                             });
  mapper.subscribe<bot_core::pose_t>("ODOMETRY", Policy::kKeepAll, [&](const bot_core::pose_t& m) {
    seen.push_back("wheels " + std::to_string(m.utime));
  });
  std::thread thread([&] { mapper.run(); });
  ConductorOptions options;
  options.processes = {"mapper"};
  options.inert = {"ODOMETRY", "GROUND_TRUTH"};
  Conductor conductor(driver, options, [] {});
  conductor.wait_for_processes(60);
  std::vector<std::string> expected;
  const auto play = [&](const LogEvent& event) {
    EXPECT_EQ(conductor.play(event), Played::kYes);
    expected.push_back((event.channel == "LIDAR" ? "scan " : "wheels ") +
                       std::to_string(event.timestamp_us));
  };
  play(odometry(11));
  play(odometry(12));
  EXPECT_TRUE(seen.empty()) << "they wait";
  LogEvent truth = odometry(20);
  truth.channel = "GROUND_TRUTH";
  EXPECT_EQ(conductor.play(truth), Played::kYes);
  play(scan(20));
  EXPECT_EQ(seen, expected);
  play(odometry(30));  // as late as the scan, later than the scan: still before it
  play(scan(30));
  play(odometry(41));
  play(scan(40));
  EXPECT_EQ(seen, expected);
  for (int i = 50; i < 150; ++i) play(odometry(i));
  EXPECT_GE(seen.size() + 40, expected.size()) << "only so many wait";
  conductor.settle();
  EXPECT_EQ(seen, expected);
  mapper.stop();
  thread.join();
}

// tracker: LIDAR -> LIDAR_POSE -> mapper -> VISUAL_POSE -> tracker, which notes what it sees.
struct Loop {
  explicit Loop(unsigned seed)
      : transport(std::make_shared<Transport>("memq://")),
        driver(named_bus("replay", Mode::kThroughput), transport),
        tracker(named_bus("tracker", Mode::kLockstep), transport),
        mapper(named_bus("mapper", Mode::kLockstep), transport),
        random(seed) {
    tracker.subscribe<bot_core::planar_lidar_t>(
        "LIDAR", Policy::kKeepAll, [this](const bot_core::planar_lidar_t& m) {
          note("scan " + std::to_string(m.utime));
          if (m.utime % 3 == 0) return;  // sometimes there is no work for the mapper
          pose_estimate_t pose{};
          pose.utime = m.utime;
          tracker.publish("LIDAR_POSE", pose);
        });
    tracker.subscribe<pose_estimate_t>(
        "VISUAL_POSE", Policy::kKeepAll, [this](const pose_estimate_t& m) {
          note("map " + std::to_string(m.utime) + "." + std::to_string(m.seq));
        });
    mapper.subscribe<pose_estimate_t>("LIDAR_POSE", Policy::kKeepAll,
                                      [this](const pose_estimate_t& m) {
                                        for (unsigned i = 0; i < 1 + m.utime % 2; ++i) {
                                          before_each(m.utime);
                                          pose_estimate_t pose{};
                                          pose.utime = m.utime;
                                          mapper.publish("VISUAL_POSE", pose);
                                        }
                                      });
    for (Bus* bus : {&tracker, &mapper}) threads.emplace_back([bus] { bus->run(); });
  }
  ~Loop() {
    for (Bus* bus : {&tracker, &mapper}) bus->stop();
    for (auto& thread : threads) thread.join();
  }

  void note(std::string what) {
    const std::lock_guard<std::mutex> lock(mutex);
    seen.push_back(std::move(what));
    changed.notify_all();
  }

  void play(int n) {
    ConductorOptions options;
    options.processes = {"tracker", "mapper"};
    options.behind = {"mapper"};
    options.most_behind = 2;
    Conductor conductor(driver, options, [] {});
    conductor.wait_for_processes(60);
    for (int i = 1; i <= n; ++i) EXPECT_EQ(conductor.play(scan(i)), Played::kYes);
    conductor.settle();
  }

  std::shared_ptr<Transport> transport;
  Bus driver, tracker, mapper;
  std::mt19937 random;
  std::function<void(std::int64_t)> before_each = [this](std::int64_t) {
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 3000));
  };
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::string> seen;
  std::vector<std::thread> threads;
};

TEST(ConductorOverlap, WhoStaysBehindChangesNothing) {
  std::vector<std::string> first;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Loop loop(seed);
    loop.play(30);
    EXPECT_EQ(loop.seen.size(), 30U + 20U + 10U);
    if (first.empty()) first = loop.seen;
    EXPECT_EQ(loop.seen, first);
  }
}

TEST(ConductorOverlap, NobodyWaitsForWhoStaysBehind) {
  Loop loop(1);
  bool went_on = false;
  loop.before_each = [&](std::int64_t utime_us) {
    if (utime_us != 2) return;  // until the next scan is handled, for which it has no work
    std::unique_lock<std::mutex> lock(loop.mutex);
    went_on = loop.changed.wait_for(lock, std::chrono::minutes(2), [&] {
      return std::find(loop.seen.begin(), loop.seen.end(), "scan 3") != loop.seen.end();
    });
  };
  loop.play(6);
  EXPECT_TRUE(went_on);
}

}  // namespace
}  // namespace fusion_slam
