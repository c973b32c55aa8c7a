// The driver through libserialport. The library refuses pseudo-terminals because they have no entry
// in /sys/class/tty and no modem lines; this program gives them both, by standing in for the three
// functions that it asks. So its own code opens, sets, reads, writes and moves DTR, on the
// virtual device.
#include <cerrno>
#include <cstdarg>
#include <cstring>
#include <mutex>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <libserialport.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <termios.h>
#include <unistd.h>

#include "tests/drivers/rplidar/rig.hpp"

namespace {

const char kClass[] = "/sys/class/tty/pts/";

bool is_pretended(const char* path) { return std::strncmp(path, kClass, sizeof kClass - 1) == 0; }

std::mutex modem_mutex;
int modem_lines = TIOCM_DTR | TIOCM_RTS;  // as after open()
std::vector<bool> dtr_history;            // what was asked for
int modem_calls = 0;

std::vector<bool> dtr_so_far() {
  const std::lock_guard<std::mutex> lock(modem_mutex);
  return dtr_history;
}

int move_lines(unsigned long request, int* lines) {
  const std::lock_guard<std::mutex> lock(modem_mutex);
  ++modem_calls;
  if (request == TIOCMGET) *lines = modem_lines;
  if (request == TIOCMBIS) modem_lines |= *lines;
  if (request == TIOCMBIC) modem_lines &= ~*lines;
  if (request != TIOCMGET && (*lines & TIOCM_DTR) != 0)
    dtr_history.push_back((modem_lines & TIOCM_DTR) != 0);
  return 0;
}

}  // namespace

extern "C" {

int ioctl(int fd, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  if (request == TIOCMGET || request == TIOCMBIS || request == TIOCMBIC)
    return move_lines(request, static_cast<int*>(argument));
  return static_cast<int>(syscall(SYS_ioctl, fd, request, argument));
}

// Debian's libserialport is built against the older name.
int old_lstat(int version, const char* path, struct stat* status) noexcept __asm__("__lxstat");
int old_lstat(int /*version*/, const char* path, struct stat* status) noexcept {
  if (!is_pretended(path)) return fstatat(AT_FDCWD, path, status, AT_SYMLINK_NOFOLLOW);
  *status = {};
  status->st_mode = S_IFLNK | 0777;
  return 0;
}

ssize_t readlink(const char* path, char* target, std::size_t size) noexcept {
  if (!is_pretended(path)) return readlinkat(AT_FDCWD, path, target, size);
  static const char kDevice[] = "../../devices/virtual/tty/rplidar";
  const std::size_t n = std::min(size, sizeof kDevice - 1);
  std::memcpy(target, kDevice, n);
  return static_cast<ssize_t>(n);
}

}  // extern "C"

namespace fusion_slam {
namespace {

TEST(LibSerialPort, CarriesTheDriver) {
  VirtualWorld world = virtual_room(18, 360);
  world.rate_hz = 12.0;
  RplidarRig rig("a1", world);
  rig.plug_in();
  sp_port* port = nullptr;
  const std::string terminal = std::filesystem::canonical(rig.port()).string();
  ASSERT_EQ(sp_get_port_by_name(terminal.c_str(), &port), SP_OK) << "the pretence failed";
  sp_free_port(port);
  rig.start();
  ASSERT_TRUE(rig.wait_for_turns(3));
  {
    const std::lock_guard<std::mutex> lock(modem_mutex);
    EXPECT_GT(modem_calls, 0);
    EXPECT_EQ(modem_lines & TIOCM_DTR, 0) << "DTR holds the motor of an A1 back";
  }
  for (const auto& [fault, said] : {std::pair(VirtualFault::kUnplug, "is gone: unplugged?"),
                                    std::pair(VirtualFault::kStall, "went silent")}) {
    const std::size_t before = rig.now();
    rig.device().set_fault(fault);
    EXPECT_TRUE(rig.wait_for_text(said, before));
    rig.device().set_fault(VirtualFault::kNone);
    const std::size_t after = rig.now();
    EXPECT_TRUE(rig.wait_for_turns(2, after));
  }
  EXPECT_THROW(SerialPort(rig.port(), 115200), PortError) << "in use";
  rig.stop();
  for (const auto& entry : rig.diary()) EXPECT_EQ(entry.wrong_beams, 0);
  ASSERT_FALSE(dtr_so_far().empty());
  EXPECT_TRUE(dtr_so_far().back()) << "at the end DTR stops the motor";
}

TEST(LibSerialPort, SpeedsOfAllModels) {
  RplidarRig rig("a1", virtual_room(2, 90));
  rig.plug_in();
  for (const int baud : {115200, 256000, 460800, 1000000})
    EXPECT_NO_THROW(SerialPort(rig.port(), baud)) << baud;
}

}  // namespace
}  // namespace fusion_slam
