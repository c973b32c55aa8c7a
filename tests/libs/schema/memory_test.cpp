// Counts what generated decoders allocate for messages that the guard accepts.
#include <gtest/gtest.h>

#include "all_types.hpp"
#include "libs/schema/guard.hpp"
#include "tests/libs/schema/counting_new.hpp"
#include "tests/libs/schema/encode.hpp"

namespace fusion_slam {
namespace {

template <class Message>
double decoded_bytes_per_byte(const Message& message) {
  const std::vector<std::uint8_t> bytes = encoded(message);
  EXPECT_FALSE(check(*builtin_schema().find(static_cast<std::uint64_t>(Message::getHash())),
                     bytes.data(), bytes.size()));
  Message decoded;
  const std::size_t before = allocated_bytes();
  EXPECT_EQ(decoded.decode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
  return static_cast<double>(allocated_bytes() - before) / static_cast<double>(bytes.size());
}

constexpr int kMany = 10000;

// Many of the smallest element of each array whose elements are structs or strings: the worst each
// type can be.
TEST(Memory, decoders_stay_below_the_documented_factor) {
  bot_core::image_t image{};
  image.metadata.resize(image.nmetadata = kMany);
  bot_core::images_t images{};
  images.image_types.resize(images.n_images = kMany);
  images.images.resize(kMany);
  loop_candidate_t candidate{};
  candidate.stages.resize(candidate.n_stages = kMany);
  status_t status{};
  status.channels.resize(status.n_channels = kMany);
  graph_t graph{};
  graph.nodes.resize(graph.n_nodes = kMany);
  step_t step{};
  step.channels.resize(step.n_channels = kMany);
  step.counts.resize(kMany);
  procman_lcm::deputy_info_t info{};
  info.cmds.resize(info.ncmds = kMany);
  procman_lcm::orders_t orders{};
  orders.cmds.resize(orders.ncmds = kMany);
  procman_lcm::output_t output{};
  output.command_ids.resize(output.num_commands = kMany);
  output.text.resize(kMany);
  for (const double factor :
       {decoded_bytes_per_byte(image), decoded_bytes_per_byte(images),
        decoded_bytes_per_byte(candidate), decoded_bytes_per_byte(status),
        decoded_bytes_per_byte(graph), decoded_bytes_per_byte(step), decoded_bytes_per_byte(info),
        decoded_bytes_per_byte(orders), decoded_bytes_per_byte(output)}) {
    EXPECT_LT(factor, static_cast<double>(kDecodedBytesPerByte));
  }
}

}  // namespace
}  // namespace fusion_slam
