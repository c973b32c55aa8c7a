// The door to LCM for programs that are no services (sheriff, deputy, doctor): no sequence numbers,
// no STATUS, no repair. Messages pass the decoder guard, wait in one queue, and are handed over on
// the caller's thread in the order they came.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "libs/bus/bus.hpp"

namespace fusion_slam {

class Mailbox {
 public:
  // Size of the message proper within the bytes that came; 0: refuse it. For signatures.
  using Filter = std::function<std::size_t(const std::uint8_t* bytes, std::size_t size_bytes)>;

  // Throws std::runtime_error as Transport does.
  explicit Mailbox(const std::string& url);
  ~Mailbox();
  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;

  // Called by handle(). The filter comes first when there is one.
  template <class Message>
  void subscribe(const std::string& channel, std::function<void(const Message&)> handler,
                 const Filter& filter = {}) {
    add(channel, Message::getHash(), bus_detail::decoder<Message>(std::move(handler)), filter,
        false);
  }
  // Called at once, on the reader's thread: for what must not wait.
  template <class Message>
  void listen(const std::string& channel, std::function<void(const Message&)> handler) {
    add(channel, Message::getHash(), bus_detail::decoder<Message>(std::move(handler)), {}, true);
  }

  // Any thread.
  template <class Message>
  void publish(const std::string& channel, const Message& message) {
    publish_bytes(channel, bus_detail::encode(message));
  }
  void publish_bytes(const std::string& channel, const std::vector<std::uint8_t>& bytes);

  // Waits up to timeout_ms for a message, then hands over all that wait; how many.
  std::size_t handle(int timeout_ms);

  std::int64_t refused() const;  // by filters and the guard; any thread
  std::int64_t dropped() const;  // because 1000 waited; any thread

 private:
  using Decode = std::function<void(const std::uint8_t* bytes, std::size_t size_bytes)>;
  void add(const std::string& channel, std::int64_t fingerprint, Decode decode, Filter filter,
           bool at_once);
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fusion_slam
