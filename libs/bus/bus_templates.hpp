// The typed face of the Bus; included by bus.hpp only.
#pragma once

#include <stdexcept>

namespace fusion_slam {
namespace bus_detail {

template <class Message, class = void>
struct HasSeq : std::false_type {};
template <class Message>
struct HasSeq<Message, std::void_t<decltype(std::declval<Message&>().seq)>> : std::true_type {};

template <class Message>
std::vector<std::uint8_t> encode(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

// Bytes that passed the guard and still are no message.
struct Undecodable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

template <class Message>
Message decode(const std::uint8_t* bytes, std::size_t size) {
  Message message;
  int used = -1;
  try {
    used = message.decode(bytes, 0, static_cast<int>(size));
  } catch (const std::exception& error) {  // out of memory
    throw Undecodable(std::string("the generated decoder failed: ") + error.what());
  }
  if (used < 0) throw Undecodable("the generated decoder refused it");
  return message;
}

template <class Message>
std::function<void(const std::uint8_t*, std::size_t)> decoder(
    std::function<void(const Message&)> handler) {
  return [handler = std::move(handler)](const std::uint8_t* bytes, std::size_t size) {
    handler(decode<Message>(bytes, size));
  };
}

}  // namespace bus_detail

template <class Message>
void Bus::subscribe(const std::string& channel, Policy policy,
                    std::function<void(const Message&)> handler) {
  subscribe_raw(channel, static_cast<std::uint64_t>(Message::getHash()), policy,
                bus_detail::decoder<Message>(std::move(handler)));
}

template <class Message>
void Bus::listen(const std::string& channel, std::function<void(const Message&)> handler) {
  listen_raw(channel, static_cast<std::uint64_t>(Message::getHash()),
             bus_detail::decoder<Message>(std::move(handler)));
}

template <class Message>
void Bus::keep_said(const std::string& channel, std::function<void(const Message&)> handler) {
  keep_said_raw(channel, static_cast<std::uint64_t>(Message::getHash()), true,
                bus_detail::decoder<Message>(std::move(handler)));
}

template <class Message>
void Bus::on_note(const std::string& channel, std::function<void(const Message&)> handler) {
  keep_said_raw(channel, static_cast<std::uint64_t>(Message::getHash()), false,
                bus_detail::decoder<Message>(std::move(handler)));
}

template <class Message>
void Bus::note(const std::string& channel, const Message& message) {
  note_raw(channel, bus_detail::encode(message));
}

template <class Message>
void Bus::publish(const std::string& channel, Message message) {
  publish_raw(channel, [&message](std::int64_t seq) {
    if constexpr (bus_detail::HasSeq<Message>::value) message.seq = seq;
    (void)seq;
    return bus_detail::encode(message);
  });
}

}  // namespace fusion_slam
