// The bus between real processes over real UDP multicast, in a network namespace of this test's
// own.
#include <atomic>
#include <cstdlib>
#include <set>
#include <thread>

#include <gtest/gtest.h>

#include "bot_core/images_t.hpp"
#include "fusion_slam/keyframe_image_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/tile_channel.hpp"
#include "libs/process/child.hpp"
#include "libs/process/private_network.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

const PrivateNetwork& network() {
  static const PrivateNetwork kNetwork = enter_private_network();
  return kNetwork;
}
bool isolated() { return network().url.find("239.255.76.67:7667") != std::string::npos; }

Child peer(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), FS_BINARY_DIR "/tests/bus_peer");
  return {"peer", arguments, std::filesystem::path(testing::TempDir()) / "bus_peer.log"};
}

template <class Condition>
bool within(int seconds, Bus& bus, Condition condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  while (!condition() && std::chrono::steady_clock::now() < deadline) bus.handle(10);
  return condition();
}

// Loss on the way, where the kernel can do it.
bool make_lossy(const char* percent) {
  return std::system(
             ("tc qdisc replace dev lo root netem loss " + std::string(percent) + " 2>/dev/null")
                 .c_str()) == 0;
}
void make_good() { (void)!std::system("tc qdisc del dev lo root 2>/dev/null"); }

class UdpBus : public testing::Test {
 protected:
  void SetUp() override {
    if (!isolated()) GTEST_SKIP() << "skipped: network namespaces are not permitted here";
    setenv("LCM_DEFAULT_URL", network().url.c_str(), 1);
  }
  void TearDown() override { make_good(); }

  void receive_images(int n, int bytes) {
    Bus bus(test_bus("receiver", Mode::kThroughput));
    std::multiset<std::int64_t> ids;
    bus.subscribe<keyframe_image_t>("KEYFRAME_IMAGE", Policy::kLatestOnly,
                                    [&](const keyframe_image_t& m) {
                                      ids.insert(m.id);
                                      for (const auto byte : m.images.images.at(0).data)
                                        ASSERT_EQ(byte, static_cast<std::uint8_t>(m.id));
                                    });
    Child sender = peer({"send", std::to_string(n), std::to_string(bytes)});
    EXPECT_TRUE(within(60, bus, [&] { return static_cast<int>(ids.size()) >= n; })) << ids.size();
    for (int i = 1; i <= n; ++i) EXPECT_EQ(ids.count(i), 1U) << i;
  }
};

TEST_F(UdpBus, ABurstOfLargeMessagesArrivesWhole) { receive_images(40, 390'000); }

TEST_F(UdpBus, SoItDoesThroughABufferTooSmallForTheBurst) {
  // The kernel drops most of the burst; what the bus asks for again comes paced.
  setenv("LCM_DEFAULT_URL", (network().url + "&recv_buf_size=120000").c_str(), 1);
  receive_images(40, 100'000);
}

TEST_F(UdpBus, SoDoMessagesWithoutNumbersInAReplay) {
  setenv("LCM_DEFAULT_URL", (network().url + "&recv_buf_size=120000").c_str(), 1);
  Bus bus(test_bus("receiver", Mode::kThroughput));
  std::multiset<std::int64_t> utimes;
  bus.subscribe<bot_core::images_t>("CAMERA", Policy::kKeepAll,
                                    [&](const bot_core::images_t& m) { utimes.insert(m.utime); });
  Child sender = peer({"camera", "40", "100000"});
  EXPECT_TRUE(within(60, bus, [&] { return utimes.size() >= 40; })) << utimes.size();
  for (int i = 1; i <= 40; ++i) EXPECT_EQ(utimes.count(i), 1U) << i;
}

TEST_F(UdpBus, SoItDoesOverALossyNetwork) {
  if (!make_lossy("5%")) GTEST_SKIP() << "skipped: this kernel has no netem";
  receive_images(40, 100'000);
}

TEST_F(UdpBus, ALateListenerIsWholeSoon) {
  Child sender = peer({"tiles", "300"});
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  Bus bus(test_bus("receiver", Mode::kLive));
  std::map<int, std::int64_t> tiles;
  TileReceiver receiver(bus, "GRID_FUSED",
                        [&](const Tile& tile) { tiles[tile.key.x] = tile.revision; });
  EXPECT_TRUE(within(10, bus, [&] { return tiles.size() == 300; })) << tiles.size();
  for (const auto& [x, revision] : tiles) EXPECT_EQ(revision % 1'000'000, 2) << x;
}

TEST_F(UdpBus, ForgedMessagesAreCountedAndHurtNobody) {
  Bus bus(test_bus("receiver", Mode::kLive));
  int handled = 0;
  bus.subscribe<tile_t>("GRID_FUSED", Policy::kKeepAll, [&](const tile_t&) { ++handled; });
  Child sender = peer({"garbage", "500"});
  const auto rejected = [&] {
    for (const auto& channel : bus.status().channels)
      if (channel.channel == "GRID_FUSED") return channel.rejected;
    return std::int64_t{0};
  };
  EXPECT_TRUE(within(20, bus, [&] { return rejected() > 400; })) << rejected();
  EXPECT_LT(handled, 100);
}

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  fusion_slam::network();  // before any thread
  return RUN_ALL_TESTS();
}
