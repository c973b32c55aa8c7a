// HTTP and WebSocket for the page, on one thread of its own (Boost.Beast). GET / and the page's
// files, GET /health, and /socket for the items. Reads the store, never waits for a browser, and
// nobody waits for it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "viz/web/item_store.hpp"
#include "viz/web/page_files.hpp"
#include "viz/web/protocol.hpp"

namespace fusion_slam {

struct ServerOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 8090;  // 0: any that is free
  std::size_t most_browsers = 32;
  std::vector<std::string> names;  // further names of this machine that browsers may use
};

class WebServer {
 public:
  // The answer to a request that is no matter of the socket itself (kCell, kCommand, kReplay): a
  // JSON object. Called on the server's thread, so it has to return at once.
  using Answer = std::function<std::string(const Request&)>;

  // Listens when it returns. Throws std::runtime_error naming the address, the port and what to do.
  WebServer(const ServerOptions& options, const ItemStore& store, PageFiles files, Answer answer);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  std::uint16_t port() const;
  std::string url() const;  // to open in a browser on this machine

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fusion_slam
