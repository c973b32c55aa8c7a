// A log's messages, for benches.
#pragma once

#include <stdexcept>

#include "libs/map_directory/decode.hpp"

namespace fusion_slam {

// Throws std::runtime_error when the bytes are no message of this type.
template <class Message>
Message decoded(const LogEvent& event) {
  std::optional<Message> message = decode<Message>(event);
  if (!message)
    throw std::runtime_error(event.channel + ": not a " + Message::getTypeName() + " of ours");
  return *std::move(message);
}

}  // namespace fusion_slam
