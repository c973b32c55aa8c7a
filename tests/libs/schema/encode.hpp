// The bytes of a generated type's message, as LCM puts them on the wire.
#pragma once

#include <cstdint>
#include <vector>

namespace fusion_slam {

template <class Message>
std::vector<std::uint8_t> encoded(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace fusion_slam
