// A listener that is killed and started again: from its journal, and by asking for what it missed.
#include <filesystem>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "fusion_slam/constraint_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/tile_channel.hpp"
#include "libs/bus/transport.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

class BusJournal : public testing::Test {
 protected:
  void SetUp() override { fs::remove(file_); }
  void TearDown() override { fs::remove(file_); }

  BusOptions options(const std::string& process) const {
    BusOptions result;
    result.process = process;
    result.merge_wait_us = 0;
    if (process == "listener") result.journal = file_;
    return result;
  }
  static constraint_t constraint(std::int64_t utime) {
    constraint_t message{};
    message.utime = utime;
    message.from_id = utime;
    return message;
  }

  fs::path file_ = fs::path(testing::TempDir()) / ("bus_journal_" + std::to_string(getpid()));
  std::shared_ptr<Transport> network_ = std::make_shared<Transport>("memq://");
};

// A process that runs until it has so many messages, then is gone at once.
struct Listener {
  Listener(const BusOptions& options, const std::shared_ptr<Transport>& network, std::size_t until)
      : bus(options, network) {
    bus.subscribe<constraint_t>("CONSTRAINT", Policy::kKeepAll,
                                [this, until](const constraint_t& m) {
                                  ids.push_back(m.from_id);
                                  bus.publish("LEVEL", m);
                                  if (ids.size() >= until) bus.stop();
                                });
    bus.keep_in_journal({"CONSTRAINT"});
    thread = std::thread([this] { bus.run(); });
  }
  ~Listener() {
    bus.stop();
    thread.join();
  }
  void finish() {
    for (int i = 0; i < 3000 && !done(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  bool done() const { return bus.status().state == status_t::STOPPING; }

  Bus bus;
  std::vector<std::int64_t> ids;  // the thread's, until it has ended
  std::thread thread;
};

TEST_F(BusJournal, IsBuiltUpAgainAndAsksForWhatItMissed) {
  Bus publisher(options("publisher"), network_);
  std::thread publishing([&] { publisher.run(); });
  std::vector<std::int64_t> first;
  std::vector<std::int64_t> second;
  std::int64_t echoed = 0;
  {
    Listener listener(options("listener"), network_, 5);
    while (listener.bus.status().state != status_t::RUNNING)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    for (int i = 1; i <= 5; ++i) publisher.publish("CONSTRAINT", constraint(i));
    listener.finish();
    listener.thread.join();
    first = listener.ids;
    listener.thread = std::thread([] {});
  }
  for (int i = 6; i <= 8; ++i) publisher.publish("CONSTRAINT", constraint(i));  // nobody hears them
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  {
    Listener listener(options("listener"), network_, 9);
    while (listener.bus.status().state == status_t::STARTING)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    publisher.publish("CONSTRAINT", constraint(9));
    listener.finish();
    listener.thread.join();
    second = listener.ids;
    echoed = listener.bus.published().at("LEVEL");
    listener.thread = std::thread([] {});
  }
  publisher.stop();
  publishing.join();
  EXPECT_THAT(first, testing::ElementsAre(1, 2, 3, 4, 5));
  ASSERT_GE(second.size(), 9U);
  EXPECT_THAT(std::vector<std::int64_t>(second.begin(), second.begin() + 5),
              testing::ElementsAre(1, 2, 3, 4, 5));
  EXPECT_THAT(second, testing::UnorderedElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_EQ(echoed, 4) << "nothing is said a second time";
}

TEST_F(BusJournal, TilesOfAProcessStartedAgainAreNewer) {
  std::map<std::int64_t, std::vector<std::uint8_t>> held;
  Bus bus(options("receiver"), network_);
  TileReceiver receiver(bus, "GRID_FUSED", [&](const Tile& tile) { held[tile.key.x] = tile.data; });
  std::int64_t utime_us = 0;
  const auto send = [&](std::uint8_t value, int n_revisions) {
    Bus sender(options("fuser"), network_);
    TilePublisher publisher(sender, "GRID_FUSED");
    for (int revision = 1; revision <= n_revisions; ++revision) {
      Tile tile;
      tile.revision = revision;
      tile.utime_us = ++utime_us;
      tile.data = {value};
      publisher.publish(tile);
    }
    for (int i = 0; i < 200 && (held.empty() || held[0][0] != value); ++i) bus.handle(10);
  };
  send(1, 7);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  send(2, 1);
  EXPECT_EQ(held[0], std::vector<std::uint8_t>{2});
}

TEST_F(BusJournal, WhatWasSaidIsStillAnsweredForAndNumbersGoOn) {
  const auto options_of_speaker = [&] {
    BusOptions result = options("speaker");
    result.journal = file_;
    return result;
  };
  std::vector<std::int64_t> restored;
  const auto speak = [&](int from, int to) {
    Bus bus(options_of_speaker(), network_);
    bus.keep_said<constraint_t>("CONSTRAINT",
                                [&](const constraint_t& m) { restored.push_back(m.from_id); });
    bus.stop();
    bus.run();  // reads the journal, handles nothing
    for (int i = from; i <= to; ++i) bus.publish("CONSTRAINT", constraint(i));
    return bus.published().at("CONSTRAINT");
  };
  EXPECT_EQ(speak(1, 3), 3);
  EXPECT_TRUE(restored.empty());
  EXPECT_EQ(speak(4, 5), 5) << "numbers go on";
  EXPECT_THAT(restored, testing::ElementsAre(1, 2, 3));
  // A listener that heard only the first asks for the rest, which an earlier process said.
  Bus speaker(options_of_speaker(), network_);
  speaker.keep_said<constraint_t>("CONSTRAINT", [](const constraint_t&) {});
  Bus listener(options("other"), network_);
  std::vector<std::int64_t> heard;
  listener.subscribe<constraint_t>("CONSTRAINT", Policy::kKeepAll,
                                   [&](const constraint_t& m) { heard.push_back(m.from_id); });
  constraint_t first = constraint(1);
  first.seq = 1;
  listener.handle(0);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(first.getEncodedSize()));
  first.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  network_->publish("CONSTRAINT", bytes);
  for (int i = 0; i < 6000 && heard.empty(); ++i) listener.handle(10);
  std::thread speaking([&] { speaker.run(); });
  for (int i = 0; i < 6000 && heard.size() < 5; ++i) listener.handle(10);
  speaker.stop();
  speaking.join();
  EXPECT_THAT(heard, testing::UnorderedElementsAre(1, 2, 3, 4, 5));
}

TEST_F(BusJournal, TilesSaidAreOfferedAgainAndNewerOnesAreNewerWhateverTheClock) {
  BusOptions with_journal = options("speaker");
  with_journal.journal = file_;
  std::int64_t before = 0;
  {
    Bus bus(with_journal, network_);
    bus.keep_said<tile_t>("SUBMAP", [](const tile_t&) {});
    bus.stop();
    bus.run();
    tile_t tile{};
    tile.revision = 5'000'000;  // as if the clock had been 5 s ahead
    bus.publish_tile("SUBMAP", tile);
    before = bus.first_revision() + tile.revision;
  }
  Bus bus(with_journal, network_);
  std::vector<std::int64_t> revisions;
  bus.keep_said<tile_t>("SUBMAP", [&](const tile_t& m) { revisions.push_back(m.revision); });
  bus.stop();
  bus.run();
  EXPECT_THAT(revisions, testing::ElementsAre(before));
  EXPECT_GE(bus.first_revision(), before);
}

}  // namespace
}  // namespace fusion_slam
