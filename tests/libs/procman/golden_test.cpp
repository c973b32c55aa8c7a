// Whole messages of procman's protocol, byte by byte: what LCM's Python encoder (lcm-gen -p, of
// another make than the C++ one that is used here) wrote of the values below.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "libs/messages/procman.hpp"
#include "procman_lcm/discovery_t.hpp"
#include "procman_lcm/output_t.hpp"

namespace fusion_slam {
namespace {

constexpr const char* kOrders =
    "d343f45b171ab855000462d53c8abac000000006726f626f74000000000770633a373a3100000000010000000376"
    "6f000000000a72756e2022612062220000000004672f6800010f3fc000000000000301";
constexpr const char* kInfo =
    "8876aeb040efd01f000462d53c8abac100000006726f626f74003e80000000000002000000000000000140000000"
    "000000004000000000000000000000070000000100000003766f000000000a72756e202261206222000000000467"
    "2f6800010f3fc00000000010e1fffffffe0000000f3f00000000000003000000000000000000010001";
constexpr const char* kDiscovery =
    "b1c83182bed74b95ffffffffffffffff0000000770633a373a3100fffffffffffffffb";
constexpr const char* kOutput =
    "8efa5caf5da01eb3000000000000000200000006726f626f7400000200000003766f000000000262000000000361"
    "0a000000000100";

std::vector<std::uint8_t> bytes(const std::string& hex) {
  std::vector<std::uint8_t> result;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    result.push_back(
        static_cast<std::uint8_t>(std::strtoul(hex.substr(i, 2).c_str(), nullptr, 16)));
  return result;
}

template <typename Message>
Message decoded(const char* hex) {
  const std::vector<std::uint8_t> data = bytes(hex);
  Message message{};
  EXPECT_EQ(message.decode(data.data(), 0, static_cast<int>(data.size())),
            static_cast<int>(data.size()));
  return message;
}

template <typename Message>
std::vector<std::uint8_t> encoded(const Message& message) {
  std::vector<std::uint8_t> data(static_cast<std::size_t>(message.getEncodedSize()));
  EXPECT_EQ(message.encode(data.data(), 0, static_cast<int>(data.size())),
            static_cast<int>(data.size()));
  return data;
}

CommandSpec spec() { return {"vo", "run \"a b\"", "g/h", true, 15, 1.5}; }

TEST(ProcmanGolden, Orders) {
  const Orders orders = from_message(decoded<procman_lcm::orders_t>(kOrders));
  EXPECT_EQ(orders.utime_us, 1234567890123456);
  EXPECT_EQ(orders.deputy, "robot");
  EXPECT_EQ(orders.sheriff, "pc:7:1");
  ASSERT_EQ(orders.commands.size(), 1U);
  EXPECT_EQ(orders.commands[0].spec, spec());
  EXPECT_EQ(orders.commands[0].desired_runid, 3);
  EXPECT_TRUE(orders.commands[0].force_quit);
  const Orders made{1234567890123456, "robot", "pc:7:1", {{spec(), 3, true}}};
  EXPECT_EQ(encoded(to_message(made)), bytes(kOrders));
}

TEST(ProcmanGolden, Info) {
  const DeputyInfo info = from_message(decoded<procman_lcm::deputy_info_t>(kInfo));
  EXPECT_EQ(info.deputy, "robot");
  EXPECT_EQ(info.load.cpu_load, 0.25F);
  EXPECT_EQ(info.load.memory_free_bytes, 5LL << 30);
  EXPECT_EQ(info.load.swap_free_bytes, 7);
  ASSERT_EQ(info.commands.size(), 1U);
  EXPECT_EQ(info.commands[0].spec, spec());
  EXPECT_EQ(info.commands[0].pid, 4321);
  EXPECT_EQ(info.commands[0].actual_runid, -2);
  const DeputyInfo made{1234567890123457,
                        "robot",
                        {0.25F, 8LL << 30, 5LL << 30, 1LL << 30, 7},
                        {{spec(), 4321, -2, 15, 0.5F, 3LL << 32, 65537}}};
  EXPECT_EQ(encoded(to_message(made)), bytes(kInfo));
}

TEST(ProcmanGolden, Discovery) {
  const auto discovery = decoded<procman_lcm::discovery_t>(kDiscovery);
  EXPECT_EQ(discovery.utime, -1);
  EXPECT_EQ(discovery.transmitter_id, "pc:7:1");
  EXPECT_EQ(discovery.nonce, -5);
  EXPECT_EQ(encoded(discovery), bytes(kDiscovery));
}

TEST(ProcmanGolden, Output) {
  const auto output = decoded<procman_lcm::output_t>(kOutput);
  EXPECT_EQ(output.deputy_id, "robot");
  EXPECT_EQ(output.command_ids, (std::vector<std::string>{"vo", "b"}));
  EXPECT_EQ(output.text, (std::vector<std::string>{"a\n", ""}));
  EXPECT_EQ(encoded(output), bytes(kOutput));
}

}  // namespace
}  // namespace fusion_slam
