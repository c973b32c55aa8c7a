// A serial line, 8N1 without flow control, through libserialport. A pseudo-terminal (socat,
// ser2net, the tests' virtual device) has no entry in /sys/class/tty and no modem lines, so that
// libserialport refuses it: those are opened with termios, everything else is the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace fusion_slam {

// What went wrong with a port, and what to do, for people.
struct PortError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// One thread at a time.
class SerialPort {
 public:
  // Takes the port for itself (flock, so that two drivers can't share one) and drops what waited in
  // it. Throws PortError: no such port, no permission, in use, a speed it can't do.
  SerialPort(const std::string& path, int baud);
  ~SerialPort();
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  // Waits up to timeout_ms for at least one byte and takes what is there, up to n_bytes; 0: nothing
  // came. Throws PortError when the port is gone (unplugged).
  std::size_t read(std::uint8_t* bytes, std::size_t n_bytes, int timeout_ms);
  // All of it or PortError.
  void write(const std::vector<std::uint8_t>& bytes);
  // DTR. Slamtec's USB adapter drives the motor's MOTOCTL with it, inverted: false lets the motor
  // run. No effect on a pseudo-terminal.
  void set_dtr(bool on);
  // Forgets what has come so far.
  void discard_input();

  const std::string& path() const { return path_; }
  int baud() const { return baud_; }

 private:
  class Backend;
  class LibSerialPort;
  class Terminal;
  void lock();

  std::string path_;
  int baud_;
  std::unique_ptr<Backend> backend_;
};

}  // namespace fusion_slam
