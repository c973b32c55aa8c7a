// A process for bus tests over real UDP: `bus_peer send N BYTES` publishes N numbered images to
// KEYFRAME_IMAGE as fast as it can; `bus_peer camera N BYTES` the same without numbers to CAMERA;
// `bus_peer tiles N` holds N tiles of GRID_FUSED; `bus_peer garbage N` sends N forged messages.
// Then it serves requests until it is stopped.
#include <iostream>
#include <random>
#include <string>
#include <thread>

#include "bot_core/images_t.hpp"
#include "fusion_slam/keyframe_image_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/tile_channel.hpp"

namespace fusion_slam {
namespace {

void send_images(Bus& bus, int n, int bytes) {
  for (int i = 1; i <= n; ++i) {
    keyframe_image_t message{};
    message.utime = i;
    message.id = i;
    message.images.n_images = 1;
    message.images.image_types = {0};
    message.images.images.resize(1);
    message.images.images[0].size = bytes;
    message.images.images[0].data.assign(static_cast<std::size_t>(bytes),
                                         static_cast<std::uint8_t>(i));
    message.images.images[0].nmetadata = 0;
    bus.publish("KEYFRAME_IMAGE", std::move(message));
  }
}

// Messages without a number, as a camera's.
void send_camera(Bus& bus, int n, int bytes) {
  for (int i = 1; i <= n; ++i) {
    bot_core::images_t message{};
    message.utime = i;
    message.n_images = 1;
    message.image_types = {0};
    message.images.resize(1);
    message.images[0].size = bytes;
    message.images[0].data.assign(static_cast<std::size_t>(bytes), static_cast<std::uint8_t>(i));
    message.images[0].nmetadata = 0;
    bus.publish("CAMERA", std::move(message));
  }
}

void send_tiles(Bus& bus, int n) {
  TilePublisher publisher(bus, "GRID_FUSED");
  for (int revision = 1; revision <= 2; ++revision)
    for (int x = 0; x < n; ++x) {
      Tile tile;
      tile.key.x = x;
      tile.revision = revision;
      tile.data.assign(2000, static_cast<std::uint8_t>(x));
      publisher.publish(tile);
    }
}

void send_garbage(Bus& bus, int n) {
  std::mt19937 rng(1);
  tile_t tile{};
  tile.size_bytes = 100;
  tile.data.assign(100, 7);
  for (int i = 0; i < n; ++i) {
    auto bytes = bus_detail::encode(tile);
    // The fingerprint stays right, so that the receiver's decoder would be reached without a guard.
    for (int k = 0; k < 8; ++k)
      bytes[8 + rng() % (bytes.size() - 8)] = static_cast<std::uint8_t>(rng());
    bytes.resize(8 + rng() % (bytes.size() - 8));
    bus.publish_bytes("GRID_FUSED", bytes);
    if (i % 50 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

int main_of(const std::string& role, int n, int bytes) {
  BusOptions options;
  if (role == "camera") options.mode = Mode::kThroughput;
  options.process = "peer";
  Bus bus(options);
  std::thread loop([&] { bus.run(); });
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  if (role == "send") send_images(bus, n, bytes);
  if (role == "camera") send_camera(bus, n, bytes);
  if (role == "tiles") send_tiles(bus, n);
  if (role == "garbage") send_garbage(bus, n);
  std::cout << "done" << std::endl;
  loop.join();
  return 0;
}

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  return fusion_slam::main_of(argv[1], std::atoi(argv[2]), argc > 3 ? std::atoi(argv[3]) : 0);
}
