// Several buses of one process over LCM's memq provider: same code as over UDP, no network.
#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "bot_core/pose_t.hpp"
#include "fusion_slam/command_t.hpp"
#include "fusion_slam/resend_t.hpp"
#include "fusion_slam/step_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/tile_channel.hpp"
#include "libs/bus/transport.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

template <class Condition>
bool soon(Condition condition) {
  for (int i = 0; i < 500 && !condition(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return condition();
}

command_t command(const std::string& verb, std::int64_t utime = 1) {
  command_t m{};
  m.utime = utime;
  m.verb = verb;
  return m;
}

TEST(BusMemq, MessagesArriveInOrderWithNumbers) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus sender(test_bus("sender"), transport);
  Bus receiver(test_bus("receiver"), transport);
  std::vector<std::int64_t> seqs;
  receiver.subscribe<command_t>("NUMBERED", Policy::kKeepAll,
                                [&](const command_t& m) { seqs.push_back(m.seq); });
  for (int i = 1; i <= 100; ++i) sender.publish("NUMBERED", command("go", i));
  EXPECT_TRUE(soon([&] {
    while (receiver.handle(10)) {
    }
    return seqs.size() == 100;
  }));
  for (std::size_t i = 0; i < seqs.size(); ++i)
    EXPECT_EQ(seqs[i], static_cast<std::int64_t>(i + 1));
  EXPECT_EQ(receiver.processed().at("NUMBERED"), 100);
  EXPECT_EQ(sender.published().at("NUMBERED"), 100);
}

TEST(BusMemq, AMessageThatLiesAboutItsLengthIsRejectedAndCounted) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus receiver(test_bus("receiver"), transport);
  int handled = 0;
  receiver.subscribe<tile_t>("GRID_FUSED", Policy::kKeepAll, [&](const tile_t&) { ++handled; });
  tile_t tile{};
  tile.size_bytes = 4;
  tile.data = {1, 2, 3, 4};
  auto bytes = bus_detail::encode(tile);
  for (std::size_t i = 0; i < 4; ++i)
    bytes[bytes.size() - 8 + i] = 0x7F;  // size_bytes: 2 thousand million
  transport->publish("GRID_FUSED", bytes);
  transport->publish("GRID_FUSED", {1, 2, 3});
  transport->publish("GRID_FUSED", {});
  const auto rejected = [&] {
    for (const auto& channel : receiver.status().channels)
      if (channel.channel == "GRID_FUSED") return channel.rejected;
    return std::int64_t{0};
  };
  EXPECT_TRUE(soon([&] { return rejected() == 3; })) << rejected();
  EXPECT_FALSE(receiver.handle(10));
  EXPECT_EQ(handled, 0);
  EXPECT_NE(receiver.status().last_error.find("GRID_FUSED"), std::string::npos);
}

TEST(BusMemq, WhatTheDecoderRefusesIsCountedAndHandledToTheEnd) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus sender(test_bus("sender"), transport);
  Bus receiver(test_bus("receiver"), transport);
  // As the decoder of a message that passed the guard and does not fit in memory.
  receiver.subscribe<command_t>("COMMAND", Policy::kKeepAll, [](const command_t&) {
    throw bus_detail::Undecodable("the generated decoder failed: std::bad_alloc");
  });
  sender.publish("COMMAND", command("go"));
  EXPECT_TRUE(soon([&] {
    receiver.handle(10);
    return receiver.processed().at("COMMAND") == 1;
  }));
  for (const auto& channel : receiver.status().channels) {
    if (channel.channel != "COMMAND") continue;
    EXPECT_EQ(channel.rejected, 1);
  }
}

TEST(BusMemq, WhatAListenerRejectsIsCountedToo) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus receiver(test_bus("receiver"), transport);
  receiver.listen<command_t>("COMMAND", [](const command_t&) {});
  transport->publish("COMMAND", {1, 2, 3});
  EXPECT_TRUE(soon([&] {
    for (const auto& channel : receiver.status().channels)
      if (channel.channel == "COMMAND") return channel.rejected == 1;
    return false;
  }));
}

TEST(BusMemq, APublisherThatStartsAgainIsHeard) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus receiver(test_bus("receiver"), transport);
  std::vector<std::int64_t> utimes;
  receiver.subscribe<command_t>("NUMBERED", Policy::kKeepAll,
                                [&](const command_t& m) { utimes.push_back(m.utime); });
  for (int life = 0; life < 3; ++life) {
    Bus sender(test_bus("sender"), transport);
    for (int i = 1; i <= 5; ++i) sender.publish("NUMBERED", command("go", 10 * life + i));
    EXPECT_TRUE(soon([&] {
      receiver.handle(10);
      return utimes.size() == 5U * (life + 1U);
    })) << utimes.size();
  }
}

TEST(BusMemq, LostMessagesAreAskedForAndCome) {
  auto transport = std::make_shared<Transport>("memq://");
  auto elsewhere = std::make_shared<Transport>("memq://");  // a network the receiver doesn't hear
  Bus receiver(test_bus("receiver", Mode::kThroughput), transport);
  std::vector<std::int64_t> seqs;
  receiver.subscribe<command_t>("NUMBERED", Policy::kKeepAll,
                                [&](const command_t& m) { seqs.push_back(m.seq); });
  Bus sender(test_bus("sender"), transport);
  for (int i = 1; i <= 5; ++i) sender.publish("NUMBERED", command("go", i));
  ASSERT_TRUE(soon([&] { return receiver.handle(10), seqs.size() == 5; }));
  // A second receiver hears of number 5 only through what the sender publishes next: it asks for 1
  // to 5.
  Bus late(test_bus("late", Mode::kThroughput), transport);
  std::vector<std::int64_t> late_seqs;
  late.subscribe<command_t>("NUMBERED", Policy::kKeepAll,
                            [&](const command_t& m) { late_seqs.push_back(m.seq); });
  sender.publish("NUMBERED", command("go", 6));
  EXPECT_TRUE(soon([&] { return late.handle(10), late_seqs.size() == 6; })) << late_seqs.size();
}

TEST(BusMemq, ALateListenerGetsTheWholeTiledState) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus sender(test_bus("sender"), transport);
  std::thread sender_loop([&] { sender.run(); });
  TilePublisher publisher(sender, "GRID_FUSED");
  for (int revision = 1; revision <= 3; ++revision)
    for (int x = 0; x < 50; ++x) {
      Tile tile;
      tile.key.x = x;
      tile.revision = revision;
      tile.data = {static_cast<std::uint8_t>(revision)};
      publisher.publish(tile);
    }
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  Bus late(test_bus("late"), transport);
  std::map<int, std::int64_t> have;
  TileReceiver receiver(late, "GRID_FUSED",
                        [&](const Tile& tile) { have[tile.key.x] = tile.revision; });
  EXPECT_TRUE(soon([&] {
    late.handle(10);
    return have.size() == 50;
  }));
  for (const auto& [x, revision] : have) EXPECT_EQ(revision % 1'000'000, 3) << x;
  sender.stop();
  sender_loop.join();
}

TEST(BusMemq, LockstepHandlesWhatStepSaysAndSaysSo) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus driver(test_bus("replay", Mode::kThroughput), transport);
  Bus worker(test_bus("worker", Mode::kLockstep), transport);
  std::vector<std::int64_t> utimes;
  worker.subscribe<bot_core::pose_t>("ODOMETRY", Policy::kKeepAll,
                                     [&](const bot_core::pose_t& m) { utimes.push_back(m.utime); });
  std::atomic<std::int64_t> answered{0};
  driver.listen<status_t>("STATUS", [&](const status_t& s) {
    if (s.process == "worker") answered = s.step;
  });
  std::thread loop([&] { worker.run(); });
  for (int i = 1; i <= 3; ++i) {
    bot_core::pose_t pose{};
    pose.utime = i;
    driver.publish("ODOMETRY", pose);
  }
  step_t step{};
  step.step = 1;
  step.n_channels = 1;
  step.channels = {"ODOMETRY"};
  step.counts = {2};
  driver.publish("STEP", step);
  EXPECT_TRUE(soon([&] { return answered == 1; }));
  EXPECT_EQ(worker.processed().at("ODOMETRY"), 2);
  step.step = 2;
  step.counts = {3};
  driver.publish("STEP", step);
  EXPECT_TRUE(soon([&] { return answered == 2; }));
  worker.stop();
  loop.join();
  EXPECT_EQ(utimes, (std::vector<std::int64_t>{1, 2, 3}));
}

TEST(BusMemq, CommandsOfTwoSendersAllArrive) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus one(test_bus("one"), transport);
  Bus two(test_bus("two"), transport);
  Bus receiver(test_bus("receiver"), transport);
  int handled = 0;
  receiver.subscribe<command_t>("COMMAND", Policy::kKeepAll, [&](const command_t&) { ++handled; });
  for (int i = 1; i <= 3; ++i) {
    one.publish("COMMAND", command("finish", i));
    two.publish("COMMAND", command("reset", i));
  }
  EXPECT_TRUE(soon([&] { return receiver.handle(10), handled == 6; })) << handled;
}

TEST(BusMemq, ClearedTilesAreGoneForEveryListenerAndRevisionsMayBeginAgain) {
  for (const Mode mode : {Mode::kLive, Mode::kThroughput}) {
    auto transport = std::make_shared<Transport>("memq://");
    Bus sender(test_bus("mapper", mode), transport);
    Bus listener(test_bus("listener", mode), transport);
    std::vector<Tile> came;
    const TileReceiver receiver(listener, "CLOUD", [&](const Tile& tile) { came.push_back(tile); });
    const auto wait_for = [&](std::size_t n) {
      return soon([&] {
        while (listener.handle(10)) {
        }
        return came.size() == n;
      });
    };
    TilePublisher publisher(sender, "CLOUD");
    Tile tile;
    tile.resolution_m = 0.05;
    tile.encoding = TileEncoding::kCloud;
    tile.data = {1, 2, 3};
    for (const std::int64_t revision : {1, 2, 3}) {
      tile.revision = revision;
      publisher.publish(tile);
    }
    tile.key.x = 1;
    tile.revision = 1;
    publisher.publish(tile);
    publisher.clear();
    ASSERT_TRUE(wait_for(6));
    EXPECT_EQ(came[4].encoding, TileEncoding::kEmpty);
    EXPECT_EQ(came[5].encoding, TileEncoding::kEmpty);
    EXPECT_TRUE(came[5].data.empty());
    publisher.publish(tile);
    ASSERT_TRUE(wait_for(7));
    EXPECT_EQ(came[6].encoding, TileEncoding::kCloud);
    publisher.clear();  // the other one is gone already: nothing is said of it
    publisher.publish(tile);
    ASSERT_TRUE(wait_for(9));
    EXPECT_EQ(came[7].encoding, TileEncoding::kEmpty);
    EXPECT_EQ(came[7].key.x, 1);
    EXPECT_EQ(came[8].encoding, TileEncoding::kCloud);
  }
}

TEST(BusMemq, WhatIsForgottenIsNotSentAgain) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus sender(test_bus("sender"), transport);
  Bus late(test_bus("late"), transport);
  std::vector<std::int64_t> seqs;
  sender.publish("NUMBERED", command("old"));
  sender.publish("NUMBERED", command("old"));
  sender.forget_sent("NUMBERED");
  sender.publish("NUMBERED", command("new"));
  late.subscribe<command_t>("NUMBERED", Policy::kKeepAll,
                            [&](const command_t& m) { seqs.push_back(m.seq); });
  resend_t request{};
  request.channel = "NUMBERED";
  request.seqs = {1, 2, 3};
  request.n_seqs = 3;
  late.publish("RESEND", request);
  ASSERT_TRUE(soon([&] {
    late.handle(10);
    return !seqs.empty();
  }));
  EXPECT_EQ(seqs, std::vector<std::int64_t>{3});
}

}  // namespace
}  // namespace fusion_slam
