#include "libs/process/child.hpp"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <deque>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

constexpr int kCouldNotStart = 127;

// In the child of a threaded parent: nothing here may allocate before exec.
[[noreturn]] void become(char* const* argv, int output, pid_t parent, int niceness) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kCouldNotStart);  // it died before we asked
  setpgid(0, 0);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  const int null = open("/dev/null", O_RDONLY);
  if (null >= 0) dup2(null, STDIN_FILENO);
  if (niceness > 0) setpriority(PRIO_PROCESS, 0, niceness);
  execvp(argv[0], argv);
  const char* reason = std::strerror(errno);
  for (const char* part : {"cannot start ", static_cast<const char*>(argv[0]), ": ", reason, "\n"})
    if (write(STDERR_FILENO, part, std::strlen(part)) < 0) break;
  _exit(kCouldNotStart);
}

}  // namespace

Child::Child(std::string name, const std::vector<std::string>& argv, std::filesystem::path log_file,
             int niceness)
    : name_(std::move(name)), log_file_(std::move(log_file)) {
  const int output = open(log_file_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (output < 0)
    throw std::runtime_error("cannot write " + log_file_.string() + ": " + std::strerror(errno));
  std::vector<char*> raw;
  raw.reserve(argv.size() + 1);
  for (const std::string& argument : argv) raw.push_back(const_cast<char*>(argument.c_str()));
  raw.push_back(nullptr);
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) become(raw.data(), output, parent, niceness);
  const int reason = errno;
  close(output);
  if (pid_ < 0) throw std::runtime_error("cannot start " + name_ + ": " + std::strerror(reason));
}

Child::Child(Child&& other) noexcept
    : name_(std::move(other.name_)),
      log_file_(std::move(other.log_file_)),
      pid_(std::exchange(other.pid_, -1)),
      ended_(std::exchange(other.ended_, true)),
      exit_code_(other.exit_code_),
      signal_(other.signal_) {}

Child::~Child() { stop(2000); }

bool Child::running() {
  if (ended_ || pid_ < 0) return false;
  int status = 0;
  const pid_t who = waitpid(pid_, &status, WNOHANG);
  if (who == 0) return true;
  ended_ = true;
  if (who != pid_) return false;  // somebody else collected it
  if (WIFEXITED(status)) exit_code_ = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) signal_ = WTERMSIG(status);
  return false;
}

std::string Child::how_it_ended() const {
  if (!ended_) return "still running";
  if (signal_ != 0) return "signal " + std::to_string(signal_) + " (" + strsignal(signal_) + ")";
  return "exit code " + std::to_string(exit_code_);
}

void Child::signal(int number) {
  if (running()) kill(pid_, number);
}

bool Child::stop(int timeout_ms, int number) {
  signal(number);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(timeout_ms);
  while (running()) {
    if (std::chrono::steady_clock::now() > deadline) {
      kill(-pid_, SIGKILL);
      kill(pid_, SIGKILL);
      while (running()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
      return false;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

std::string Child::last_lines(std::size_t n) const {
  std::ifstream file(log_file_);
  std::deque<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    lines.push_back(line);
    if (lines.size() > n) lines.pop_front();
  }
  std::string text;
  for (const std::string& line : lines) text += "    " + line + "\n";
  return text.empty() ? "    (it printed nothing)\n" : text;
}

}  // namespace fusion_slam
