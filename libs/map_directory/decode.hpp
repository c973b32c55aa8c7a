// A message out of a log's bytes. For bytes that have passed check() of libs/schema.
#pragma once

#include <optional>

#include "libs/eventlog/event.hpp"

namespace fusion_slam {

// Nothing when the bytes are no message of this type.
template <class Message>
std::optional<Message> decode(const LogEvent& event) {
  Message message;
  const int size = static_cast<int>(event.data.size());
  if (message.decode(event.data.data(), 0, size) != size) return std::nullopt;
  return message;
}

}  // namespace fusion_slam
