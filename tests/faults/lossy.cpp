// LD_PRELOAD: a process that hears only part of what the network sends. Stands in for netem where
// the kernel has none: FS_LOSS_PERCENT of all datagrams that arrive are thrown away (each process
// by a seed of its own, FS_LOSS_SEED plus its number), and all of them while the file FS_CUT_FILE
// exists (of the programs FS_CUT_NAMES alone, if there is such a list). And a process whose wall
// clock jumps: by the seconds in the file FS_CLOCK_FILE.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <dlfcn.h>
#include <errno.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

namespace {

double number_of(const char* variable, double otherwise) {
  const char* value = std::getenv(variable);
  return value == nullptr ? otherwise : std::strtod(value, nullptr);
}

std::uint64_t next_random() {  // splitmix64; LCM reads on one thread
  static std::uint64_t state =
      static_cast<std::uint64_t>(number_of("FS_LOSS_SEED", 1)) * 0x9E3779B97F4A7C15U +
      static_cast<std::uint64_t>(getpid());
  state += 0x9E3779B97F4A7C15U;
  std::uint64_t z = state;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31U);
}

bool is_on_the_list() {
  const char* names = std::getenv("FS_CUT_NAMES");
  return names == nullptr || std::strstr(names, program_invocation_short_name) != nullptr;
}

bool unlucky() {
  static const double percent = number_of("FS_LOSS_PERCENT", 0.0);
  static const char* cut = is_on_the_list() ? std::getenv("FS_CUT_FILE") : nullptr;
  if (cut != nullptr && access(cut, F_OK) == 0) return true;
  return static_cast<double>(next_random() >> 11U) * 0x1.0p-53 < percent / 100.0;
}

time_t jump_s() {
  static const char* path = std::getenv("FS_CLOCK_FILE");
  if (path == nullptr) return 0;
  std::FILE* file = std::fopen(path, "r");
  if (file == nullptr) return 0;
  char text[32] = {};
  const std::size_t n = std::fread(text, 1, sizeof text - 1, file);
  std::fclose(file);
  return n == 0 ? 0 : std::strtol(text, nullptr, 10);
}

}  // namespace

extern "C" int clock_gettime(clockid_t clock, timespec* now) noexcept {
  using Function = int (*)(clockid_t, timespec*);
  static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "clock_gettime"));
  const int result = real(clock, now);
  if (result == 0 && clock == CLOCK_REALTIME) now->tv_sec += jump_s();
  return result;
}

extern "C" ssize_t recvmsg(int file, msghdr* message, int flags) {
  using Function = ssize_t (*)(int, msghdr*, int);
  static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "recvmsg"));
  for (;;) {
    const auto name = message->msg_namelen;
    const auto control = message->msg_controllen;
    const ssize_t n = real(file, message, flags);
    if (n < 0 || !unlucky()) return n;
    message->msg_namelen = name;
    message->msg_controllen = control;
  }
}
