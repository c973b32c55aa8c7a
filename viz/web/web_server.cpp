#include "viz/web/web_server.hpp"

#include <chrono>
#include <deque>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

#include <boost/asio.hpp>
#include <boost/beast.hpp>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "viz/web/admission.hpp"
#include "viz/web/client_feed.hpp"

namespace fusion_slam {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using beast::error_code;
using HttpRequest = http::request<http::string_body>;
using HttpResponse = http::response<http::string_body>;

constexpr auto kTick = std::chrono::milliseconds(33);
constexpr auto kHttpTimeout = std::chrono::seconds(20);
constexpr std::size_t kMostAnswers = 64;       // that a browser asked for and does not read
constexpr std::size_t kMostConnections = 256;  // browsers open several for files
constexpr const char* kPolicy =
    "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; "
    "connect-src 'self' ws: wss:; frame-ancestors 'none'; base-uri 'none'";

std::int64_t monotonic_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::string text(beast::string_view view) { return {view.data(), view.size()}; }

class Browser;

// What all connections share; used on the server's thread only.
struct Shared {
  ServerOptions options;
  const ItemStore& store;
  PageFiles files;
  WebServer::Answer answer;
  std::set<std::string> names;
  std::set<std::shared_ptr<Browser>> browsers;
  std::size_t connections = 0;
  std::uint64_t bytes_sent = 0;
};

// One page that is open somewhere.
class Browser : public std::enable_shared_from_this<Browser> {
 public:
  Browser(tcp::socket socket, Shared& shared)
      : socket_(std::move(socket)), shared_(shared), feed_(shared.store) {}

  void start(const HttpRequest& request) {
    auto timeout = websocket::stream_base::timeout::suggested(beast::role_type::server);
    timeout.keep_alive_pings = true;
    socket_.set_option(timeout);
    socket_.read_message_max(kMaxRequestBytes);
    socket_.binary(true);
    socket_.async_accept(request, [self = shared_from_this()](error_code error) {
      if (error) return self->leave();
      self->read();
      self->pump();
    });
  }

  // Sends what may be sent now.
  void pump() {
    if (writing_ || !socket_.is_open()) return;
    const bool is_answer = !answers_.empty();
    if (is_answer) {
      outgoing_ = std::move(answers_.front());
      answers_.pop_front();
    } else if (auto batch = feed_.next(monotonic_us())) {
      outgoing_ = std::move(*batch);
    } else {
      return;
    }
    writing_ = true;
    socket_.binary(!is_answer);
    shared_.bytes_sent += outgoing_.size();
    socket_.async_write(asio::buffer(outgoing_),
                        [self = shared_from_this()](error_code error, std::size_t) {
                          self->writing_ = false;
                          if (error) return self->leave();
                          self->pump();
                        });
  }

  void close() {
    error_code ignored;
    socket_.next_layer().close(ignored);
  }
  std::uint64_t bytes_sent() const { return feed_.bytes_sent(); }
  std::uint32_t under_way() const { return feed_.under_way(); }

 private:
  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return self->leave();
      const auto data = self->buffer_.cdata();
      self->take({static_cast<const char*>(data.data()), data.size()});
      self->buffer_.consume(self->buffer_.size());
      if (self->answers_.size() > kMostAnswers) return self->leave();
      self->pump();
      self->read();
    });
  }

  void take(std::string_view bytes) {
    std::string why;
    const auto request = parse_request(bytes, &why);
    if (!request)
      answers_.push_back(nlohmann::ordered_json({{"error", "request refused: " + why}}).dump());
    else if (request->kind == Request::Kind::kAck)
      feed_.acknowledge(request->batch);
    else if (request->kind == Request::Kind::kWant)
      feed_.want(request->topics);
    else
      answers_.push_back(shared_.answer(*request));
  }

  void leave() {
    close();
    shared_.browsers.erase(shared_from_this());
  }

  websocket::stream<tcp::socket> socket_;
  Shared& shared_;
  ClientFeed feed_;
  beast::flat_buffer buffer_{kMaxRequestBytes};
  std::string outgoing_;
  std::deque<std::string> answers_;
  bool writing_ = false;
};

std::string health_of(const Shared& shared) {
  nlohmann::ordered_json browsers = nlohmann::ordered_json::array();
  for (const auto& browser : shared.browsers)
    browsers.push_back(
        {{"bytes_sent", browser->bytes_sent()}, {"batches_under_way", browser->under_way()}});
  return nlohmann::ordered_json({{"page", shared.files.complete() ? "built" : "missing"},
                                 {"bytes_sent", shared.bytes_sent},
                                 {"browsers", browsers}})
      .dump();
}

HttpResponse response_to(const HttpRequest& request, const Shared& shared) {
  HttpResponse response{http::status::ok, request.version()};
  response.set(http::field::server, "fusion-slam");
  response.set(http::field::cache_control, "no-cache");
  response.set(http::field::x_frame_options, "DENY");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Content-Security-Policy", kPolicy);
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  response.keep_alive(request.keep_alive());
  const std::string target = text(request.target());
  const std::string path = target.substr(0, target.find('?'));
  const PageFile* file = shared.files.find(path);
  if (!is_our_host(text(request[http::field::host]), shared.names)) {
    response.result(http::status::misdirected_request);
    response.body() =
        "This name is not this machine's. Use its address, or start the viewer with --name.\n";
  } else if (request.method() != http::verb::get && request.method() != http::verb::head) {
    response.result(http::status::method_not_allowed);
    response.body() = "Only GET and HEAD.\n";
  } else if (path == "/health") {
    response.set(http::field::content_type, "application/json");
    response.body() = health_of(shared);
  } else if (file != nullptr) {
    response.set(http::field::content_type, file->content_type);
    response.body() = file->content;
  } else {
    response.result(http::status::not_found);
    response.body() = "There is no such page here. The viewer is at /\n";
  }
  response.prepare_payload();
  if (request.method() == http::verb::head) response.body().clear();
  return response;
}

// A connection until it is closed or becomes a Browser.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, Shared& shared) : stream_(std::move(socket)), shared_(shared) {
    ++shared_.connections;
  }
  ~Connection() { --shared_.connections; }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void read() {
    parser_.emplace();
    parser_->body_limit(kMaxRequestBytes);
    stream_.expires_after(kHttpTimeout);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](error_code error, std::size_t) {
                       if (!error) self->serve();
                     });
  }

 private:
  void serve() {
    const HttpRequest request = parser_->release();
    if (websocket::is_upgrade(request) && request.target() == "/socket" && admitted(request)) {
      stream_.expires_never();
      auto browser = std::make_shared<Browser>(stream_.release_socket(), shared_);
      shared_.browsers.insert(browser);
      return browser->start(request);
    }
    response_ = response_to(request, shared_);
    if (websocket::is_upgrade(request)) {
      response_.result(shared_.browsers.size() >= shared_.options.most_browsers
                           ? http::status::service_unavailable
                           : http::status::forbidden);
      response_.keep_alive(false);
    }
    http::async_write(stream_, response_,
                      [self = shared_from_this()](error_code error, std::size_t) {
                        if (!error && self->response_.keep_alive()) return self->read();
                        error_code ignored;
                        self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
                      });
  }

  bool admitted(const HttpRequest& request) const {
    const std::string host = text(request[http::field::host]);
    return shared_.browsers.size() < shared_.options.most_browsers &&
           is_our_host(host, shared_.names) &&
           is_our_page(text(request[http::field::origin]), host);
  }

  beast::tcp_stream stream_;
  Shared& shared_;
  beast::flat_buffer buffer_{16 * 1024};
  std::optional<http::request_parser<http::string_body>> parser_;
  HttpResponse response_;
};

std::set<std::string> our_names(const ServerOptions& options) {
  std::set<std::string> names;
  for (const std::string& name : options.names) names.insert(host_name_of(name));
  char name[256] = {};
  if (gethostname(name, sizeof(name) - 1) != 0) return names;
  const std::string host = host_name_of(name);
  names.insert({host, host + ".local"});
  return names;
}

}  // namespace

struct WebServer::Impl {
  Impl(const ServerOptions& options, const ItemStore& store, PageFiles files, Answer answer)
      : shared{options, store, std::move(files), std::move(answer), our_names(options), {}, 0, 0} {}

  void accept() {
    acceptor.async_accept([this](error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (!error && shared.connections < kMostConnections)
        std::make_shared<Connection>(std::move(socket), shared)->read();
      accept();
    });
  }

  void tick() {
    timer.expires_after(kTick);
    timer.async_wait([this](error_code error) {
      if (error) return;
      const auto browsers = shared.browsers;
      for (const auto& browser : browsers) browser->pump();
      tick();
    });
  }

  Shared shared;
  asio::io_context context{1};
  tcp::acceptor acceptor{context};
  asio::steady_timer timer{context};
  std::thread thread;
};

WebServer::WebServer(const ServerOptions& options, const ItemStore& store, PageFiles files,
                     Answer answer)
    : impl_(std::make_unique<Impl>(options, store, std::move(files), std::move(answer))) {
  try {
    const tcp::endpoint endpoint(asio::ip::make_address(options.address), options.port);
    impl_->acceptor.open(endpoint.protocol());
    impl_->acceptor.set_option(asio::socket_base::reuse_address(true));
    impl_->acceptor.bind(endpoint);
    impl_->acceptor.listen();
  } catch (const std::exception& error) {
    throw std::runtime_error("cannot listen on " + options.address + " port " +
                             std::to_string(options.port) + ": " + error.what() +
                             ". Give an address of this machine with --listen (127.0.0.1: this "
                             "machine only, 0.0.0.0: all) and a free port with --port");
  }
  impl_->accept();
  impl_->tick();
  impl_->thread = std::thread([impl = impl_.get()] { impl->context.run(); });
}

WebServer::~WebServer() {
  impl_->context.stop();
  impl_->thread.join();
  impl_->shared.browsers.clear();
}

std::uint16_t WebServer::port() const { return impl_->acceptor.local_endpoint().port(); }

std::string WebServer::url() const {
  const auto endpoint = impl_->acceptor.local_endpoint();
  std::string host = endpoint.address().to_string();
  if (endpoint.address().is_unspecified()) host = "127.0.0.1";
  if (endpoint.address().is_v6() && !endpoint.address().is_unspecified()) host = "[" + host + "]";
  return "http://" + host + ":" + std::to_string(endpoint.port()) + "/";
}

}  // namespace fusion_slam
