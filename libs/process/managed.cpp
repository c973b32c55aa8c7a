#include "libs/process/managed.hpp"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <map>

#include <fcntl.h>
#include <grp.h>
#include <pty.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

extern char** environ;

namespace fusion_slam {
namespace {

constexpr int kCouldNotStart = 127;

std::vector<std::string> merged_environment(
    const std::vector<std::pair<std::string, std::string>>& added) {
  std::map<std::string, std::string> variables;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    variables[text.substr(0, text.find('='))] = text;
  }
  for (const auto& [name, value] : added) {
    std::string& text = variables[name];
    text = name;
    text.append("=").append(value);
  }
  std::vector<std::string> result;
  result.reserve(variables.size());
  for (const auto& [name, text] : variables) result.push_back(text);
  return result;
}

std::vector<char*> pointers(const std::vector<std::string>& texts) {
  std::vector<char*> result;
  result.reserve(texts.size() + 1);
  for (const std::string& text : texts) result.push_back(const_cast<char*>(text.c_str()));
  result.push_back(nullptr);
  return result;
}

struct Plan {
  const char* program;
  char* const* argv;
  char* const* environment;
  int terminal;
  pid_t parent;
  const std::pair<uid_t, gid_t>* user;
};

[[noreturn]] void give_up(const char* doing, const char* what) {
  const char* reason = std::strerror(errno);
  for (const char* part : {doing, what, ": ", reason, "\n"})
    if (write(STDERR_FILENO, part, std::strlen(part)) < 0) break;
  _exit(kCouldNotStart);
}

// In the child of a threaded parent: nothing here may allocate before exec.
[[noreturn]] void become(const Plan& plan) {
  setsid();
  for (int number = 1; number < 32; ++number) std::signal(number, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const int null = open("/dev/null", O_RDONLY);
  if (null >= 0) dup2(null, STDIN_FILENO);
  dup2(plan.terminal, STDOUT_FILENO);
  dup2(plan.terminal, STDERR_FILENO);
  if (plan.user != nullptr) {
    const auto& [uid, gid] = *plan.user;
    if (setgroups(0, nullptr) != 0 || setgid(gid) != 0 || setuid(uid) != 0)
      give_up("cannot become the user for ", plan.program);
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // setuid(2) clears it: so only now
  if (getppid() != plan.parent) _exit(kCouldNotStart);
  execve(plan.program, plan.argv, plan.environment);
  give_up("cannot start ", plan.program);
}

}  // namespace

std::optional<Spawned> spawn(const SpawnRequest& request, std::string* why) {
  const std::vector<std::string> environment = merged_environment(request.environment);
  const std::vector<char*> argv = pointers(request.argv);
  const std::vector<char*> variables = pointers(environment);
  int ours = -1;
  int theirs = -1;
  if (openpty(&ours, &theirs, nullptr, nullptr, nullptr) != 0) {
    *why = std::string("cannot open a pseudo-terminal: ") + std::strerror(errno);
    return std::nullopt;
  }
  termios settings{};
  if (tcgetattr(theirs, &settings) == 0) {
    cfmakeraw(&settings);  // bytes as they are: no \r before \n
    tcsetattr(theirs, TCSANOW, &settings);
  }
  fcntl(ours, F_SETFD, FD_CLOEXEC);
  fcntl(theirs, F_SETFD, FD_CLOEXEC);
  fcntl(ours, F_SETFL, O_NONBLOCK);
  const Plan plan{request.program.c_str(),
                  argv.data(),
                  variables.data(),
                  theirs,
                  getpid(),
                  request.user ? &*request.user : nullptr};
  const pid_t pid = fork();
  if (pid == 0) become(plan);
  const int reason = errno;
  close(theirs);
  if (pid > 0) return Spawned{pid, ours};
  close(ours);
  *why = std::string("cannot start a process: ") + std::strerror(reason);
  return std::nullopt;
}

void adopt_orphans() { prctl(PR_SET_CHILD_SUBREAPER, 1); }

std::vector<Reaped> reap() {
  std::vector<Reaped> result;
  for (;;) {
    int status = 0;
    const pid_t pid = waitpid(-1, &status, WNOHANG);
    if (pid <= 0) return result;
    result.push_back({pid, status});
  }
}

std::string read_output(int output, std::size_t most_bytes, bool* ended) {
  std::string text(most_bytes, '\0');
  std::size_t filled = 0;
  *ended = false;
  while (filled < most_bytes) {
    const ssize_t n = read(output, text.data() + filled, most_bytes - filled);
    if (n > 0) {
      filled += static_cast<std::size_t>(n);
      continue;
    }
    if (n < 0 && errno == EINTR) continue;
    *ended = n == 0 || errno != EAGAIN;  // EIO: nobody holds the other end any more
    break;
  }
  text.resize(filled);
  return text;
}

}  // namespace fusion_slam
