// The server through plain sockets, as something other than a browser would use it.
#include "viz/web/web_server.hpp"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

class Socket {
 public:
  explicit Socket(std::uint16_t port) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience{20, 0};
    setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    connected_ = connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0;
  }
  ~Socket() { close(fd_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  bool connected() const { return connected_; }

  void send_text(const std::string& text) const {
    ASSERT_EQ(send(fd_, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
  }
  // Until `end` has come, or `most` bytes, or nothing more.
  std::string read_until(const std::string& end, std::size_t most = 1 << 24) const {
    std::string text;
    char buffer[65536];
    while (text.size() < most && text.find(end) == std::string::npos) {
      const ssize_t n = recv(fd_, buffer, sizeof(buffer), 0);
      if (n <= 0) break;
      text.append(buffer, static_cast<std::size_t>(n));
    }
    return text;
  }
  // A text message as browsers send it: masked, here with zeros.
  void send_message(const std::string& text) const {
    ASSERT_LT(text.size(), 126U);
    std::string frame{'\x81', static_cast<char>(0x80 | text.size()), 0, 0, 0, 0};
    send_text(frame + text);
  }

 private:
  int fd_;
  bool connected_ = false;
};

class WebServerTest : public ::testing::Test {
 protected:
  WebServerTest() {
    std::string folder = ::testing::TempDir() + "/web_server_XXXXXX";
    directory_ = mkdtemp(folder.data());
    std::ofstream(directory_ / "index.html") << "<p>the page</p>";
    std::ofstream(directory_ / "secret.key") << "not for browsers";
    ServerOptions options;
    options.port = 0;
    options.most_browsers = 3;
    server_ = std::make_unique<WebServer>(options, store_, PageFiles(directory_),
                                          [](const Request&) { return R"({"answer":42})"; });
  }
  ~WebServerTest() override {
    server_.reset();
    std::filesystem::remove_all(directory_);
  }

  std::string ask(const std::string& request) const {
    const Socket socket(server_->port());
    socket.send_text(request);
    return socket.read_until("no such text", 1 << 20);
  }
  static std::string get(const std::string& path, const std::string& host = "localhost") {
    return "GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n";
  }
  static std::string upgrade(const std::string& extra, const std::string& host = "localhost") {
    return "GET /socket HTTP/1.1\r\nHost: " + host +
           "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
           "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
           extra + "\r\n";
  }

  std::filesystem::path directory_;
  ItemStore store_;
  std::unique_ptr<WebServer> server_;
};

TEST_F(WebServerTest, ServesThePageAndNothingElse) {
  EXPECT_NE(ask(get("/")).find("the page"), std::string::npos);
  EXPECT_NE(ask(get("/?theme=dark")).find("the page"), std::string::npos);
  EXPECT_NE(ask(get("/health")).find("\"page\":\"built\""), std::string::npos);
  for (const char* path :
       {"/secret.key", "/../web_server_test.cpp", "/..%2fsecret.key", "//etc/passwd", "/nothing"})
    EXPECT_EQ(ask(get(path)).rfind("HTTP/1.1 404", 0), 0U) << path;
  EXPECT_EQ(
      ask("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")
          .rfind("HTTP/1.1 405", 0),
      0U);
  EXPECT_EQ(ask(get("/", "evil.example")).rfind("HTTP/1.1 421", 0), 0U);
}

TEST_F(WebServerTest, NonsenseEndsTheConnectionAndNotTheServer) {
  for (const char* text :
       {"\r\n\r\n\r\n", "GET\r\n\r\n", "\x16\x03\x01\x02", "GET / HTTP/9.9\r\n\r\n"}) {
    const Socket socket(server_->port());
    socket.send_text(text);
  }
  EXPECT_NE(ask(get("/")).find("the page"), std::string::npos);
}

TEST_F(WebServerTest, OtherPagesGetNoSocket) {
  for (const std::string& request : {upgrade("Origin: http://evil.example\r\n"),
                                     upgrade("Origin: null\r\n"), upgrade("", "evil.example")}) {
    const Socket socket(server_->port());
    socket.send_text(request);
    EXPECT_EQ(socket.read_until("\r\n\r\n").rfind("HTTP/1.1 403", 0), 0U) << request;
  }
  const Socket own(server_->port());
  own.send_text(upgrade("Origin: http://localhost\r\n"));
  const std::string answer = own.read_until("\r\n\r\n");
  EXPECT_EQ(answer.rfind("HTTP/1.1 101", 0), 0U) << answer;
  EXPECT_NE(answer.find("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), std::string::npos);  // RFC 6455, 1.3
}

TEST_F(WebServerTest, AnswersAndRefusals) {
  const Socket socket(server_->port());
  socket.send_text(upgrade(""));
  socket.read_until("\r\n\r\n");
  socket.send_message(R"({"type":"cell","id":1,"x":0,"y":0})");
  EXPECT_NE(socket.read_until("42}").find(R"({"answer":42})"), std::string::npos);
  socket.send_message("what?");
  EXPECT_NE(socket.read_until("}").find("request refused"), std::string::npos);
}

// One that reads nothing at all holds up neither the one that does, nor the store, nor the end of
// the server.
TEST_F(WebServerTest, ASleepingBrowserHoldsUpNobody) {
  for (int i = 0; i < 200; ++i)
    store_.put(Topic::kCloud, std::to_string(i), std::string(100'000, 'x'));
  const Socket asleep(server_->port());
  asleep.send_text(upgrade(""));
  asleep.send_message(R"({"type":"want","topics":["cloud","pose"]})");
  const Socket awake(server_->port());
  awake.send_text(upgrade(""));
  awake.read_until("\r\n\r\n");
  awake.send_message(R"({"type":"want","topics":["pose"]})");
  for (int i = 0; i < 5; ++i) {
    store_.put(Topic::kPose, "", "here " + std::to_string(i) + ";");
    EXPECT_NE(awake.read_until(std::to_string(i) + ";").find("here"), std::string::npos);
    awake.send_message(R"({"type":"ack","batch":)" + std::to_string(i + 1) + "}");
  }
}

TEST_F(WebServerTest, TooManyBrowsersAreToldSo) {
  std::vector<std::unique_ptr<Socket>> open;
  for (int i = 0; i < 3; ++i) {
    open.push_back(std::make_unique<Socket>(server_->port()));
    open.back()->send_text(upgrade(""));
    EXPECT_EQ(open.back()->read_until("\r\n\r\n").rfind("HTTP/1.1 101", 0), 0U);
  }
  const Socket fourth(server_->port());
  fourth.send_text(upgrade(""));
  EXPECT_EQ(fourth.read_until("\r\n\r\n").rfind("HTTP/1.1 503", 0), 0U);
}

TEST_F(WebServerTest, APortThatIsTakenIsNamed) {
  ServerOptions options;
  options.port = server_->port();
  try {
    const WebServer second(options, store_, PageFiles(directory_), {});
    FAIL() << "two servers on one port";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find(std::to_string(options.port)), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("--port"), std::string::npos);
  }
}

TEST(PageFiles, AMissingPageSaysHowItIsBuilt) {
  const PageFiles files("/no/such/folder");
  EXPECT_FALSE(files.complete());
  ASSERT_NE(files.find("/"), nullptr);
  EXPECT_NE(files.find("/")->content.find("npm"), std::string::npos);
}

}  // namespace
}  // namespace fusion_slam
