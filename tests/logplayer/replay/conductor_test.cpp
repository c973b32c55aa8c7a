// A small pipeline over memq: source -> (double, triple) -> join. What join sees must depend on the
// log alone.
#include "logplayer/replay/conductor.hpp"

#include <atomic>
#include <map>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "bot_core/images_t.hpp"
#include "bot_core/pose_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "libs/bus/transport.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

// Passes ODOMETRY on to `out`, `copies` times, after an unpredictable time.
class Relay {
 public:
  Relay(Bus& bus, const std::string& out, int copies, unsigned seed) : rng_(seed) {
    bus.subscribe<bot_core::pose_t>(
        "ODOMETRY", Policy::kKeepAll, [this, &bus, out, copies](const bot_core::pose_t& pose) {
          for (int i = 0; i < copies; ++i) {
            std::this_thread::sleep_for(std::chrono::microseconds(rng_() % 2000));
            pose_estimate_t estimate{};
            estimate.utime = pose.utime;
            estimate.frame = out;
            bus.publish(out, estimate);
          }
        });
  }

 private:
  std::mt19937 rng_;
};

struct Pipeline {
  Pipeline(Mode mode, unsigned seed)
      : transport(std::make_shared<Transport>("memq://")),
        driver(named_bus("replay", Mode::kThroughput), transport),
        bus_double(named_bus("double", mode), transport),
        bus_triple(named_bus("triple", mode), transport),
        bus_join(named_bus("join", mode), transport),
        relay_double(bus_double, "VISUAL_POSE", 2, seed),
        relay_triple(bus_triple, "LIDAR_POSE", 3, seed + 1) {
    for (const char* channel : {"VISUAL_POSE", "LIDAR_POSE"})
      bus_join.subscribe<pose_estimate_t>(
          channel, Policy::kLatestOnly, [this](const pose_estimate_t& m) {
            seen.push_back(std::to_string(m.utime) + m.frame + std::to_string(m.seq));
          });
    for (Bus* bus : {&bus_double, &bus_triple, &bus_join})
      threads.emplace_back([bus] { bus->run(); });
  }
  ~Pipeline() {
    for (Bus* bus : {&bus_double, &bus_triple, &bus_join}) bus->stop();
    for (auto& thread : threads) thread.join();
  }

  void play(Mode mode, int n) {
    ConductorOptions options;
    options.mode = mode;
    options.processes = {"double", "triple", "join"};
    Conductor conductor(driver, options, [] {});
    conductor.wait_for_processes(10);
    for (int i = 1; i <= n; ++i) {
      bot_core::pose_t pose{};
      pose.utime = i;
      EXPECT_EQ(conductor.play({0, i, i, "ODOMETRY", bus_detail::encode(pose)}), Played::kYes);
      if (mode == Mode::kLockstep) {
        EXPECT_EQ(seen.size(), static_cast<std::size_t>(5 * i)) << "digested before the next event";
      }
      if (i > 1) continue;  // of a channel's first message all know before there is a second
      for (const auto& [name, peer] : conductor.peers())
        for (const auto& channel : peer.channels) {
          if (channel.channel == "ODOMETRY") {
            EXPECT_EQ(channel.processed, 1) << name;
          }
        }
    }
    conductor.settle();
  }

  std::shared_ptr<Transport> transport;
  Bus driver;
  Bus bus_double;
  Bus bus_triple;
  Bus bus_join;
  Relay relay_double;
  Relay relay_triple;
  std::vector<std::string> seen;
  std::vector<std::thread> threads;
};

TEST(Conductor, LockstepIsTheSameEachTime) {
  std::vector<std::string> first;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Pipeline pipeline(Mode::kLockstep, seed);
    pipeline.play(Mode::kLockstep, 20);
    EXPECT_EQ(pipeline.seen.size(), 100U);
    if (first.empty()) first = pipeline.seen;
    EXPECT_EQ(pipeline.seen, first);
  }
}

// A frame that is sent before its turn is handled in its turn.
TEST(Conductor, SendingAheadChangesNothing) {
  const auto transport = std::make_shared<Transport>("memq://");
  Bus driver(named_bus("replay", Mode::kThroughput), transport);
  Bus eyes(named_bus("eyes", Mode::kLockstep), transport);
  std::vector<std::int64_t> seen;
  eyes.subscribe<bot_core::images_t>("CAMERA", Policy::kLatestOnly,
                                     [&](const bot_core::images_t& m) { seen.push_back(m.utime); });
  eyes.subscribe<bot_core::pose_t>("ODOMETRY", Policy::kLatestOnly,
                                   [&](const bot_core::pose_t& m) { seen.push_back(m.utime); });
  std::thread thread([&] { eyes.run(); });
  ConductorOptions options;
  options.processes = {"eyes"};
  Conductor conductor(driver, options, [] {});
  conductor.wait_for_processes(10);
  const auto frame = [](int i) {
    bot_core::images_t images{};
    images.utime = 10 * i;
    images.n_images = 1;
    images.image_types = {bot_core::images_t::LEFT};
    images.images.resize(1);
    images.images[0].size = 100'000;
    images.images[0].data.resize(100'000);
    return LogEvent{i, 2 * i, i, "CAMERA", bus_detail::encode(images)};
  };
  std::vector<std::int64_t> expected;
  for (int i = 1; i <= 5; ++i) {
    const LogEvent next = frame(i + 1);
    EXPECT_EQ(conductor.play(frame(i), &next), Played::kYes);
    expected.push_back(10 * i);
    EXPECT_EQ(seen, expected);
    bot_core::pose_t pose{};
    pose.utime = 10 * i + 1;
    EXPECT_EQ(conductor.play({i, 2 * i + 1, i, "ODOMETRY", bus_detail::encode(pose)}, &next),
              Played::kYes);
    EXPECT_EQ(driver.published()["CAMERA"], i + 1) << "sent when the one before was handled";
    EXPECT_EQ(conductor.counts()["CAMERA"], i) << "and not counted yet";
    expected.push_back(10 * i + 1);
    EXPECT_EQ(seen, expected);
  }
  EXPECT_EQ(conductor.play(frame(6)), Played::kYes);
  EXPECT_EQ(driver.published()["CAMERA"], 6);
  EXPECT_EQ(conductor.play(frame(6)), Played::kRepeat);
  eyes.stop();
  thread.join();
}

TEST(Conductor, ThroughputLosesNothing) {
  Pipeline pipeline(Mode::kThroughput, 1);
  pipeline.play(Mode::kThroughput, 100);
  EXPECT_EQ(pipeline.seen.size(), 500U);
}

TEST(Conductor, AnExactRepeatIsNotPlayed) {
  Pipeline pipeline(Mode::kLockstep, 1);
  ConductorOptions options;
  options.processes = {"double", "triple", "join"};
  Conductor conductor(pipeline.driver, options, [] {});
  conductor.wait_for_processes(10);
  const LogEvent event{0, 1, 1, "ODOMETRY", bus_detail::encode(bot_core::pose_t{})};
  EXPECT_EQ(conductor.play(event), Played::kYes);
  EXPECT_EQ(conductor.play(event), Played::kRepeat);
  EXPECT_EQ(pipeline.seen.size(), 5U);
}

TEST(Conductor, WhatListenersWouldRejectIsNotPlayed) {
  Pipeline pipeline(Mode::kLockstep, 1);
  ConductorOptions options;
  options.processes = {"double", "triple", "join"};
  Conductor conductor(pipeline.driver, options, [] {});
  conductor.wait_for_processes(10);
  LogEvent event{0, 1, 1, "ODOMETRY", bus_detail::encode(bot_core::pose_t{})};
  event.data.pop_back();
  EXPECT_EQ(conductor.play(event), Played::kUndecodable);
  event.data = bus_detail::encode(pose_estimate_t{});
  EXPECT_EQ(conductor.play(event), Played::kUndecodable) << "another type";
  event.data = {1, 2, 3};
  EXPECT_EQ(conductor.play(event), Played::kUndecodable);
  event.data = bus_detail::encode(bot_core::pose_t{});
  EXPECT_EQ(conductor.play(event), Played::kYes);
  EXPECT_EQ(pipeline.seen.size(), 5U);
}

TEST(Conductor, InThroughputModeStatusTellsListenersWhatWasSent) {
  Pipeline pipeline(Mode::kThroughput, 1);
  std::atomic<std::int64_t> told{0};
  pipeline.bus_join.listen<status_t>("STATUS", [&](const status_t& status) {
    if (status.process != "replay") return;
    for (const auto& channel : status.channels)
      if (channel.channel == "ODOMETRY") told = channel.published;
  });
  pipeline.play(Mode::kThroughput, 10);
  for (int i = 0; i < 500 && told < 10; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(told, 10);
}

// A frame may be lost and come again: the next must not be sent before it is there.
TEST(Conductor, InThroughputModeLargeMessagesKeepTheirOrder) {
  const auto transport = std::make_shared<Transport>("memq://");
  Bus driver(named_bus("replay", Mode::kThroughput), transport);
  Bus ears(named_bus("ears", Mode::kThroughput), transport);
  const auto say = [&](std::int64_t received) {
    status_t status{};
    status.process = "other";
    status.state = status_t::RUNNING;
    channel_stats_t camera{};
    camera.channel = "CAMERA";
    camera.subscribed = 1;
    camera.received = received;
    camera.processed = 1;
    status.channels = {camera};
    status.n_channels = 1;
    ears.publish("STATUS", status);
  };
  ConductorOptions options;
  options.mode = Mode::kThroughput;
  options.processes = {"other"};
  std::map<std::int64_t, int> looks;  // frames sent -> how often the conductor polled then
  Conductor conductor(driver, options, [&] {
    const std::int64_t sent = driver.published()["CAMERA"];
    if (++looks[sent] == 4) say(sent);
  });
  say(0);
  conductor.wait_for_processes(10);
  for (int i = 1; i <= 3; ++i) {
    bot_core::images_t frame{};
    frame.utime = i;
    frame.n_images = 1;
    frame.image_types = {bot_core::images_t::LEFT};
    frame.images.resize(1);
    frame.images[0].utime = i;
    frame.images[0].size = 100'000;
    frame.images[0].data.resize(100'000);
    EXPECT_EQ(conductor.play({0, i, i, "CAMERA", bus_detail::encode(frame)}), Played::kYes);
  }
  EXPECT_GE(looks[2], 4) << "the third was sent before the second was there";
}

TEST(Conductor, NamesWhoIsMissing) {
  Pipeline pipeline(Mode::kLockstep, 1);
  ConductorOptions options;
  options.processes = {"double", "absent"};
  Conductor conductor(pipeline.driver, options, [] {});
  try {
    conductor.wait_for_processes(2);
    FAIL() << "should have said who is absent";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find(" absent"), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find(" double"), std::string::npos) << error.what();
  }
}

TEST(Conductor, PollEndsTheWait) {
  Pipeline pipeline(Mode::kLockstep, 1);
  ConductorOptions options;
  options.processes = {"absent"};
  Conductor conductor(pipeline.driver, options, [] { throw std::runtime_error("interrupted"); });
  EXPECT_THROW(conductor.wait_for_processes(60), std::runtime_error);
}

}  // namespace
}  // namespace fusion_slam
