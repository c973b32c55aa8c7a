// Bytes of a log or of the network into a message, behind the decoder guard.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "libs/schema/guard.hpp"

namespace fusion_slam {

// Nothing when the bytes are not exactly one Message.
template <class Message>
std::optional<Message> decode_guarded(const std::vector<std::uint8_t>& bytes) {
  const LcmType* type = builtin_schema().find(static_cast<std::uint64_t>(Message::getHash()));
  if (type == nullptr || check(*type, bytes.data(), bytes.size())) return std::nullopt;
  Message message;
  if (message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) return std::nullopt;
  return message;
}

}  // namespace fusion_slam
