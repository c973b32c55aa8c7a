#include "procman/sheriff/local_deputy.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "libs/netcheck/machine.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

fs::path state_folder() {
  if (const char* state = std::getenv("XDG_STATE_HOME")) return fs::path(state) / "fusion-slam";
  const char* home = std::getenv("HOME");
  return fs::path(home != nullptr ? home : "/tmp") / ".local/state/fusion-slam";
}

[[noreturn]] void become_deputy(char* const* argv, int log) {
  setsid();
  if (fork() != 0) _exit(0);  // the grandchild belongs to nobody
  const int null = open("/dev/null", O_RDONLY);
  if (null >= 0) dup2(null, STDIN_FILENO);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  execv(argv[0], argv);
  _exit(127);
}

}  // namespace

std::string start_local_deputy(const std::string& lcm_url, const std::string& key_file) {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "procman-deputy";
  if (!fs::exists(program)) throw std::runtime_error(program.string() + " is missing");
  const fs::path folder = state_folder();
  fs::create_directories(folder);
  const fs::path log_file = folder / "procman-deputy.log";
  std::vector<std::string> argv{program, "--name",       kLocalDeputy,   "--until-idle",
                                "20",    "--log-folder", folder.string()};
  argv.insert(argv.end(), {"--allow", program.parent_path().string()});
  for (const char* const tool : {"lcm-logger", "lcm-logplayer"})
    if (const fs::path path = find_program(tool); !path.empty())
      argv.insert(argv.end(), {"--allow", path.string()});
  if (!lcm_url.empty()) argv.insert(argv.end(), {"--lcm-url", lcm_url});
  if (!key_file.empty()) argv.insert(argv.end(), {"--key", fs::absolute(key_file).string()});
  std::vector<char*> raw;
  raw.reserve(argv.size() + 1);
  for (std::string& argument : argv) raw.push_back(argument.data());
  raw.push_back(nullptr);
  const int log = open(log_file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (log < 0)
    throw std::runtime_error("cannot write " + log_file.string() + ": " + std::strerror(errno));
  const pid_t pid = fork();
  if (pid == 0) become_deputy(raw.data(), log);
  close(log);
  if (pid < 0)
    throw std::runtime_error(std::string("cannot start a deputy: ") + std::strerror(errno));
  waitpid(pid, nullptr, 0);
  return log_file.string();
}

}  // namespace fusion_slam
