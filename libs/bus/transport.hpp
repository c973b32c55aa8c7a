// An LCM handle and the thread that empties it. LCM's own queue drops the newest message when 30
// wait, so this thread does nothing but copy; policies are the Bus's. One Transport may serve
// several buses of a process (memq://).
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace fusion_slam {

class Transport {
 public:
  using Receive = std::function<void(const std::string& channel, const std::uint8_t* bytes,
                                     std::size_t size_bytes)>;

  // Reading starts at once; for a log file (file://), which would play to nobody, with start().
  // Asks udpm for a receive buffer of 4 MiB unless the URL says otherwise. Throws
  // std::runtime_error naming the URL and what to do.
  explicit Transport(const std::string& url);
  ~Transport();
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  void start();  // any thread, any number of times

  // Called on the reader's thread for each message of the channel, until the returned token is
  // destroyed.
  std::shared_ptr<void> subscribe(const std::string& channel, Receive receive);
  // Called on the reader's thread between messages, at least every 20 ms while the token lives.
  std::shared_ptr<void> on_idle(std::function<void()> callback);

  void publish(const std::string& channel, const std::vector<std::uint8_t>& bytes);  // any thread
  const std::string& url() const;
  bool at_end() const;  // a log file has been read to its end

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Adds recv_buf_size to a udpm URL that has none; an empty URL becomes LCM_DEFAULT_URL or LCM's
// default.
std::string complete_url(const std::string& url);

}  // namespace fusion_slam
