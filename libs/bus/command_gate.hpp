// COMMAND in a lab with a key: only who knows it gives commands. Behind the message go 8 bytes
// (wall clock in us, big-endian) and the signature of both (libs/authentication); LCM's decoders
// stop where the message ends, so listeners without a key read it as it is. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libs/authentication/signature.hpp"

namespace fusion_slam {

std::vector<std::uint8_t> sign_command(const SigningKey& key,
                                       const std::vector<std::uint8_t>& message,
                                       std::int64_t wall_us);

class CommandGate {
 public:
  // Without a key everything passes. What was signed before `started_us` is refused: it may have
  // been recorded.
  CommandGate(std::optional<SigningKey> key, std::int64_t started_us)
      : key_(std::move(key)), started_us_(started_us) {}

  // Size of the message alone; nothing, and why, when it is refused.
  std::optional<std::size_t> admit(const std::uint8_t* bytes, std::size_t size_bytes,
                                   std::int64_t wall_us, std::string* why);

  static constexpr std::int64_t kGreatestAge_us = 60'000'000;  // either way: clocks differ

 private:
  std::optional<SigningKey> key_;
  std::int64_t started_us_;
  std::map<std::vector<std::uint8_t>, std::int64_t> seen_;  // signatures of the last minutes
};

}  // namespace fusion_slam
