#include "libs/bus/command_gate.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

constexpr std::int64_t kNow_us = 1'700'000'000'000'000;
const std::vector<std::uint8_t> kMessage{1, 2, 3, 4, 5, 6, 7, 8, 9, 10};

SigningKey key(std::uint8_t first = 1) {
  std::vector<std::uint8_t> bytes(32, 7);
  bytes[0] = first;
  return SigningKey(bytes);
}

std::string refusal(CommandGate& gate, const std::vector<std::uint8_t>& bytes,
                    std::int64_t now_us = kNow_us) {
  std::string why;
  const auto size = gate.admit(bytes.data(), bytes.size(), now_us, &why);
  if (size) {
    EXPECT_EQ(*size, kMessage.size());
  }
  EXPECT_EQ(why.empty(), size.has_value());
  return why;
}

TEST(CommandGate, WithoutAKeyEverythingPassesSignedOrNot) {
  CommandGate gate(std::nullopt, kNow_us);
  EXPECT_EQ(refusal(gate, kMessage), "");
  EXPECT_EQ(refusal(gate, sign_command(key(), kMessage, kNow_us)), "");
}

TEST(CommandGate, WithAKeyOnlyWhatWasSignedWithItPassesAndOnce) {
  CommandGate gate(key(), kNow_us - 1);
  const auto good = sign_command(key(), kMessage, kNow_us);
  EXPECT_NE(refusal(gate, kMessage), "") << "not signed";
  EXPECT_NE(refusal(gate, sign_command(key(2), kMessage, kNow_us)), "") << "another key";
  for (std::size_t i = 0; i < good.size(); ++i) {
    auto damaged = good;
    damaged[i] ^= 1;
    EXPECT_NE(refusal(gate, damaged), "") << "byte " << i;
  }
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_NE(refusal(gate, {good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)}), "");
  EXPECT_EQ(refusal(gate, good), "");
  EXPECT_NE(refusal(gate, good, kNow_us + 1), "") << "a replay";
  EXPECT_EQ(refusal(gate, sign_command(key(), kMessage, kNow_us + 1)), "") << "said once more";
}

TEST(CommandGate, RecordedOnesAreRefusedByAProcessStartedLater) {
  const auto recorded = sign_command(key(), kMessage, kNow_us);
  CommandGate later(key(), kNow_us + 1);
  EXPECT_NE(refusal(later, recorded, kNow_us + 2), "");
  CommandGate elder(key(), 0);
  EXPECT_NE(refusal(elder, recorded, kNow_us + CommandGate::kGreatestAge_us + 1), "");
}

}  // namespace
}  // namespace fusion_slam
