// A listener that is killed and started again: from its journal, and by asking for what it missed.
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "fusion_slam/command_t.hpp"
#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/resend_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/journal_mark.hpp"
#include "libs/bus/tile_channel.hpp"
#include "libs/bus/transport.hpp"
#include "libs/journal/journal.hpp"
#include "libs/schema/guard.hpp"

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

// A source whose ids are those of its messages, as visual_odometry's are.
struct Source {
  Source(const BusOptions& options, const std::shared_ptr<Transport>& network)
      : bus(options, network), ids(bus) {
    bus.keep_said<constraint_t>("CONSTRAINT", [this](const constraint_t& m) {
      restored.push_back(m.from_id);
      ids.said(m.from_id);
    });
    bus.stop();
    bus.run();  // reads the journal, handles nothing
  }
  Bus bus;
  SourceIds ids;
  std::vector<std::int64_t> restored;
};

TEST_F(BusJournal, NoIdIsGivenTwiceWhereverTheJournalIsCut) {
  BusOptions with_journal = options("source");
  with_journal.journal = file_;
  std::uintmax_t before_bytes = 0;
  {
    Source source(with_journal, network_);
    EXPECT_EQ(source.ids.next(), 1);
    for (int i = 1; i <= 4; ++i) {
      before_bytes = fs::file_size(file_);
      source.bus.publish("CONSTRAINT", constraint(i));
    }
  }
  const fs::path whole = file_.string() + "_whole";
  fs::copy_file(file_, whole, fs::copy_options::overwrite_existing);
  const std::uintmax_t after_bytes = fs::file_size(file_);
  ASSERT_GT(after_bytes, before_bytes + 100);
  for (std::uintmax_t size = before_bytes + 1; size < after_bytes; size += 7) {
    fs::copy_file(whole, file_, fs::copy_options::overwrite_existing);
    fs::resize_file(file_, size);
    {
      Source source(with_journal, network_);
      EXPECT_THAT(source.restored, testing::ElementsAre(1, 2, 3)) << size;
      EXPECT_EQ(source.ids.next(), 1001) << size;
      EXPECT_EQ(source.bus.published().at("CONSTRAINT"), 1000) << "4 was heard";
    }
    Source again(with_journal, network_);  // killed before it said anything
    EXPECT_EQ(again.ids.next(), 1001) << size;
    again.bus.publish("CONSTRAINT", constraint(1001));
    EXPECT_EQ(again.bus.published().at("CONSTRAINT"), 1001);
  }
  {
    Source killed(with_journal, network_);
    EXPECT_THAT(killed.restored, testing::ElementsAre(1, 2, 3, 1001));
    EXPECT_EQ(killed.ids.next(), 1002) << "all was there: ids go on";
    EXPECT_EQ(killed.bus.published().at("CONSTRAINT"), 1001);
  }
  fs::resize_file(file_, 10);
  EXPECT_EQ(Source(with_journal, network_).ids.next(), 1001) << "nothing is left";
  fs::resize_file(file_, 0);
  EXPECT_EQ(Source(with_journal, network_).ids.next(), 1001) << "nothing is left of the file";
  fs::remove(whole);
}

TEST_F(BusJournal, AfterAMachineWasStartedAgainWholeRecordsMayBeLost) {
  BusOptions with_journal = options("source");
  with_journal.journal = file_;
  {
    command_t mark{};
    mark.verb = kJournalOpened;
    mark.argument = "another start of the machine";
    constraint_t said = constraint(3);
    said.seq = 3;
    Journal journal(file_);
    const auto append = [&](const char* channel, const auto& message) {
      std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
      message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
      ASSERT_TRUE(journal.append(1, channel, bytes.data(), bytes.size()));
    };
    append(kJournalMark, mark);
    append("CONSTRAINT", said);
  }
  EXPECT_EQ(Source(with_journal, network_).ids.next(), 1001);
  EXPECT_EQ(Source(with_journal, network_).ids.next(), 1001) << "of this start of the machine";
}

TEST_F(BusJournal, ListenersDontMissNumbersThatWereNeverGiven) {
  BusOptions with_journal = options("source");
  with_journal.journal = file_;
  Bus listener(options("other"), network_);
  std::vector<std::int64_t> heard;
  listener.subscribe<constraint_t>("CONSTRAINT", Policy::kKeepAll,
                                   [&](const constraint_t& m) { heard.push_back(m.from_id); });
  const auto hear = [&](std::size_t n) {
    for (int i = 0; i < 12000 && heard.size() < n; ++i) listener.handle(10);
  };
  listener.handle(0);
  {
    Source source(with_journal, network_);
    for (int i = 1; i <= 3; ++i) source.bus.publish("CONSTRAINT", constraint(i));
    hear(3);
  }
  fs::resize_file(file_, fs::file_size(file_) - 5);
  std::mutex mutex;
  std::vector<std::int64_t> told;
  listener.listen<resend_t>("RESEND", [&](const resend_t& m) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (!m.seqs.empty() && m.seqs[0] < 0) told = m.seqs;
  });
  const auto is_told = [&] {
    const std::lock_guard<std::mutex> lock(mutex);
    return !told.empty();
  };
  Bus speaker(with_journal, network_);
  speaker.keep_said<constraint_t>("CONSTRAINT", [](const constraint_t&) {});
  std::thread speaking([&] { speaker.run(); });
  while (speaker.status().state != status_t::RUNNING)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  speaker.publish("CONSTRAINT", constraint(4));
  hear(4);
  resend_t request{};  // the listener asks, too, unless this machine stood still for 2 s
  request.channel = "CONSTRAINT";
  request.seqs = {4};
  request.n_seqs = 1;
  for (int i = 0; i < 1200 && !is_told(); ++i) {
    listener.publish("RESEND", request);
    listener.handle(100);
  }
  speaker.stop();
  speaking.join();
  EXPECT_THAT(heard, testing::ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(told, testing::ElementsAre(-3, -1000));
}

std::map<std::string, std::vector<std::int64_t>> records(const fs::path& file) {
  std::map<std::string, std::vector<std::int64_t>> seqs;
  read_journal(file, [&](const LogEvent& event) {
    seqs[event.channel].push_back(peek_seq(event.data.data(), event.data.size()).value_or(0));
  });
  return seqs;
}

TEST_F(BusJournal, WrittenAnewItGoesOnWithAllNumbersAndHoldsWhatIsNeeded) {
  BusOptions with_journal = options("speaker");
  with_journal.journal = file_;
  std::map<std::string, std::vector<std::int64_t>> handled;  // by the life that is on
  std::vector<std::int64_t> noted;
  std::vector<std::int64_t> asked;
  std::mutex mutex;
  Bus world(options("world"), network_);
  world.listen<resend_t>("RESEND", [&](const resend_t& m) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (m.channel == "CONSTRAINT") asked.insert(asked.end(), m.seqs.begin(), m.seqs.end());
  });
  const auto live = [&](const std::function<void(Bus&)>& on_bus) {
    handled.clear();
    noted.clear();
    Bus bus(with_journal, network_);
    for (const char* channel : {"CONSTRAINT", "LEVEL"})
      bus.subscribe<constraint_t>(channel, Policy::kKeepAll, [&, channel](const constraint_t& m) {
        handled[channel].push_back(m.from_id);
      });
    bus.keep_in_journal({"CONSTRAINT", "LEVEL"});
    std::vector<std::int64_t> said;
    bus.keep_said<constraint_t>("POSES", [&](const constraint_t& m) { said.push_back(m.from_id); });
    bus.on_note<constraint_t>("NOTE", [&](const constraint_t& m) { noted.push_back(m.from_id); });
    Bus::JournalNeeds needs;
    needs.first_of = {"LEVEL"};
    needs.numbers = [](const std::string&) { return std::set<std::int64_t>{2, 5}; };
    needs.note_state = [&] { bus.note("NOTE", constraint(77)); };
    bus.keep_journal_small(std::move(needs));
    bus.stop();
    bus.run();  // reads the journal
    on_bus(bus);
    return said;
  };
  const auto hear = [&](Bus& bus, const char* channel, std::size_t n) {
    for (int i = 0; i < 120'000 && handled[channel].size() < n; ++i)
      if (!bus.handle(0)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(handled[channel].size(), n) << channel;
  };
  live([&](Bus& bus) {
    bus.handle(0);
    for (int i = 1; i <= 6; ++i) world.publish("CONSTRAINT", constraint(i));
    for (int i = 1; i <= 3; ++i) world.publish("LEVEL", constraint(i));
    hear(bus, "CONSTRAINT", 6);
    hear(bus, "LEVEL", 3);
    for (int i = 1; i <= 4; ++i) bus.publish("POSES", constraint(10 + i));
    bus.note("NOTE", constraint(1));
    ASSERT_TRUE(bus.renew_journal());
    bus.note("NOTE", constraint(78));
  });
  EXPECT_THAT(records(file_)["CONSTRAINT"], testing::ElementsAre(2, 5));
  EXPECT_THAT(records(file_)["LEVEL"], testing::ElementsAre(1));
  const auto said = live([&](Bus& bus) {
    EXPECT_THAT(handled["CONSTRAINT"], testing::ElementsAre(2, 5));
    EXPECT_THAT(handled["LEVEL"], testing::ElementsAre(1));
    EXPECT_THAT(noted, testing::ElementsAre(77, 78));
    EXPECT_EQ(bus.published()["POSES"], 4);
    // The seventh is lost on the way and asked for; those left out of the journal are not.
    constraint_t eighth = constraint(8);
    eighth.seq = 8;
    network_->publish("CONSTRAINT", bus_detail::encode(eighth));
    const auto asks = [&] {
      const std::lock_guard<std::mutex> lock(mutex);
      return !asked.empty();
    };
    for (int i = 0; i < 12'000 && !asks(); ++i) {
      bus.handle(5);
      world.handle(5);
    }
    const std::lock_guard<std::mutex> lock(mutex);
    for (const std::int64_t seq : asked) EXPECT_TRUE(seq == 7 || seq > 8) << seq;
    EXPECT_FALSE(asked.empty());
  });
  EXPECT_THAT(said, testing::ElementsAre(11, 12, 13, 14));
  // Written anew a second time, by a process that has only read it, and cut: no number is lost.
  live([&](Bus& bus) { EXPECT_TRUE(bus.renew_journal()); });
  live([&](Bus& bus) {
    EXPECT_THAT(handled["CONSTRAINT"], testing::ElementsAre(2, 5));
    EXPECT_THAT(noted, testing::ElementsAre(77));
    EXPECT_EQ(bus.published()["POSES"], 4);
  });
}

}  // namespace
}  // namespace fusion_slam
