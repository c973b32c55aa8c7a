#include "libs/bus/command_gate.hpp"

#include <cstdlib>

namespace fusion_slam {
namespace {

constexpr std::size_t kTimeBytes = 8;

std::int64_t time_of(const std::uint8_t* bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < kTimeBytes; ++i) value = (value << 8U) | bytes[i];
  return static_cast<std::int64_t>(value);
}

}  // namespace

std::vector<std::uint8_t> sign_command(const SigningKey& key,
                                       const std::vector<std::uint8_t>& message,
                                       std::int64_t wall_us) {
  std::vector<std::uint8_t> timed = message;
  for (int shift = 56; shift >= 0; shift -= 8)
    timed.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(wall_us) >> shift));
  return key.sign("COMMAND", timed);
}

std::optional<std::size_t> CommandGate::admit(const std::uint8_t* bytes, std::size_t size_bytes,
                                              std::int64_t wall_us, std::string* why) {
  const std::size_t unsigned_size = size_without_signature(bytes, size_bytes);
  const bool is_signed = unsigned_size < size_bytes && unsigned_size >= kTimeBytes;
  if (!key_) return is_signed ? unsigned_size - kTimeBytes : size_bytes;
  const auto timed = key_->verify("COMMAND", bytes, size_bytes);
  if (!timed || *timed < kTimeBytes) {
    *why = "a COMMAND without a good signature is refused: its sender needs this lab's key";
    return std::nullopt;
  }
  const std::int64_t signed_us = time_of(bytes + *timed - kTimeBytes);
  if (signed_us < started_us_ || std::llabs(wall_us - signed_us) > kGreatestAge_us) {
    *why =
        "a signed COMMAND is refused: made before this process began, or clocks are off by "
        "more than 60 s";
    return std::nullopt;
  }
  for (auto it = seen_.begin(); it != seen_.end();)
    it = it->second < wall_us - 2 * kGreatestAge_us ? seen_.erase(it) : std::next(it);
  if (!seen_.emplace(std::vector<std::uint8_t>(bytes + *timed, bytes + size_bytes), signed_us)
           .second) {
    *why = "a signed COMMAND came twice: the second is refused";
    return std::nullopt;
  }
  return *timed - kTimeBytes;
}

}  // namespace fusion_slam
