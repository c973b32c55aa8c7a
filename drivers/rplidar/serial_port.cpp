#include "drivers/rplidar/serial_port.hpp"

#include <cerrno>
#include <chrono>
#include <climits>
#include <cstdlib>
#include <cstring>

#include <fcntl.h>
#include <libserialport.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

constexpr int kWriteTimeoutMs = 200;

std::string real_path(const std::string& path) {
  char resolved[PATH_MAX];
  return realpath(path.c_str(), resolved) != nullptr ? resolved : path;
}

[[noreturn]] void fail_to_open(const std::string& path, int reason) {
  if (reason == ENOENT)
    throw PortError("there is no port " + path + ": plug the LiDAR in, or name another port");
  if (reason == EACCES || reason == EPERM)
    throw PortError("no permission for " + path +
                    ": install config/udev/99-fusion-slam.rules, or 'sudo adduser $USER dialout' "
                    "and log in again");
  if (reason == EBUSY) throw PortError(path + " is in use by another program");
  throw PortError("cannot open " + path + ": " + std::strerror(reason));
}

}  // namespace

class SerialPort::Backend {
 public:
  virtual ~Backend() = default;
  virtual int fd() const = 0;
  // As read(2) and write(2), without blocking: -1 is an error.
  virtual ssize_t read(std::uint8_t* bytes, std::size_t n) = 0;
  virtual ssize_t write(const std::uint8_t* bytes, std::size_t n) = 0;
  virtual void set_dtr(bool on) = 0;
  virtual void discard_input() = 0;
};

class SerialPort::LibSerialPort : public SerialPort::Backend {
 public:
  // Takes over what find() has found.
  LibSerialPort(sp_port* port, const std::string& path, int baud) : port_(port) {
    try {
      if (sp_open(port_, SP_MODE_READ_WRITE) != SP_OK) fail_to_open(path, errno);
      open_ = true;
      if (sp_set_bits(port_, 8) != SP_OK || sp_set_parity(port_, SP_PARITY_NONE) != SP_OK ||
          sp_set_stopbits(port_, 1) != SP_OK ||
          sp_set_flowcontrol(port_, SP_FLOWCONTROL_NONE) != SP_OK)
        throw PortError(path + " can't be set to 8 bits, no parity: is it a serial port?");
      if (sp_set_baudrate(port_, baud) != SP_OK)
        throw PortError(path + " can't do " + std::to_string(baud) + " baud");
      if (sp_get_port_handle(port_, &fd_) != SP_OK) throw PortError(path + " has no descriptor");
    } catch (...) {
      free_port();
      throw;
    }
  }
  // Null when libserialport knows no such port. It wants the device's own name: not /dev/rplidar.
  static sp_port* find(const std::string& path) {
    sp_port* port = nullptr;
    return sp_get_port_by_name(path.c_str(), &port) == SP_OK ? port : nullptr;
  }
  ~LibSerialPort() override { free_port(); }
  LibSerialPort(const LibSerialPort&) = delete;
  LibSerialPort& operator=(const LibSerialPort&) = delete;

  int fd() const override { return fd_; }
  ssize_t read(std::uint8_t* bytes, std::size_t n) override {
    return sp_nonblocking_read(port_, bytes, n);
  }
  ssize_t write(const std::uint8_t* bytes, std::size_t n) override {
    return sp_nonblocking_write(port_, bytes, n);
  }
  void set_dtr(bool on) override { sp_set_dtr(port_, on ? SP_DTR_ON : SP_DTR_OFF); }
  void discard_input() override { sp_flush(port_, SP_BUF_INPUT); }

 private:
  void free_port() {
    if (open_) sp_close(port_);
    sp_free_port(port_);
  }
  sp_port* port_;
  bool open_ = false;
  int fd_ = -1;
};

class SerialPort::Terminal : public SerialPort::Backend {
 public:
  explicit Terminal(const std::string& path)
      : fd_(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    if (fd_ < 0) fail_to_open(path, errno);
    termios settings{};
    if (tcgetattr(fd_, &settings) != 0) {
      ::close(fd_);
      throw PortError(path + " is no terminal");
    }
    cfmakeraw(&settings);
    tcsetattr(fd_, TCSANOW, &settings);
  }
  ~Terminal() override { ::close(fd_); }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  int fd() const override { return fd_; }
  ssize_t read(std::uint8_t* bytes, std::size_t n) override { return retry(::read(fd_, bytes, n)); }
  ssize_t write(const std::uint8_t* bytes, std::size_t n) override {
    return retry(::write(fd_, bytes, n));
  }
  void set_dtr(bool /*on*/) override {}
  void discard_input() override { tcflush(fd_, TCIFLUSH); }

 private:
  static ssize_t retry(ssize_t n) { return n < 0 && (errno == EAGAIN || errno == EINTR) ? 0 : n; }
  int fd_;
};

SerialPort::SerialPort(const std::string& path, int baud) : path_(path), baud_(baud) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) fail_to_open(path, errno);
  if (sp_port* port = LibSerialPort::find(real_path(path)))
    backend_ = std::make_unique<LibSerialPort>(port, path, baud);
  else if (real_path(path).rfind("/dev/pts/", 0) == 0)
    backend_ = std::make_unique<Terminal>(path);
  else
    throw PortError(path + " is no serial port");
  if (flock(backend_->fd(), LOCK_EX | LOCK_NB) != 0) fail_to_open(path, EBUSY);
  discard_input();
}

SerialPort::~SerialPort() = default;

std::size_t SerialPort::read(std::uint8_t* bytes, std::size_t n_bytes, int timeout_ms) {
  pollfd waiting{backend_->fd(), POLLIN, 0};
  const int ready = poll(&waiting, 1, timeout_ms);
  if (ready == 0 || (ready < 0 && errno == EINTR)) return 0;
  // An unplugged line hangs up, or is readable and yet empty.
  const bool readable = ready > 0 && (waiting.revents & POLLIN) != 0;
  const ssize_t n = readable ? backend_->read(bytes, n_bytes) : -1;
  if (n <= 0) throw PortError(path_ + " is gone: unplugged?");
  return static_cast<std::size_t>(n);
}

void SerialPort::write(const std::vector<std::uint8_t>& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = backend_->write(bytes.data() + done, bytes.size() - done);
    if (n < 0) throw PortError(path_ + " is gone: unplugged?");
    done += static_cast<std::size_t>(n);
    if (done == bytes.size()) break;
    pollfd waiting{backend_->fd(), POLLOUT, 0};
    if (poll(&waiting, 1, kWriteTimeoutMs) == 0)
      throw PortError(path_ + " takes no bytes: is something holding the line?");
    if ((waiting.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0)
      throw PortError(path_ + " is gone: unplugged?");
  }
}

void SerialPort::set_dtr(bool on) { backend_->set_dtr(on); }
void SerialPort::discard_input() { backend_->discard_input(); }

}  // namespace fusion_slam
