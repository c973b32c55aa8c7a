// A child process whose output goes to a file, and which dies with us.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

namespace fusion_slam {

class Child {
 public:
  // niceness > 0: gives way to others when the processors are busy (nice(2)).
  // Starts argv[0] (a path) with stdout and stderr appended to log_file. The child is in its own
  // process group (a Ctrl-C at the terminal reaches only us) and gets SIGKILL when the calling
  // thread's process ends in any way. Throws std::runtime_error naming the program when it can't be
  // started.
  Child(std::string name, const std::vector<std::string>& argv, std::filesystem::path log_file,
        int niceness = 0);
  Child(Child&& other) noexcept;
  Child& operator=(Child&&) = delete;
  Child(const Child&) = delete;
  ~Child();  // stop(2000)

  const std::string& name() const { return name_; }
  pid_t pid() const { return pid_; }

  // False once it has ended; then how_it_ended() says "exit code 1" or "signal 11 (Segmentation
  // fault)".
  bool running();
  std::string how_it_ended() const;
  bool ended_well() const { return ended_ && exit_code_ == 0; }

  void signal(int number);
  // `number` now, SIGKILL after timeout_ms; returns when it is gone. True when it needed no
  // SIGKILL.
  bool stop(int timeout_ms, int number = 15);

  std::string last_lines(std::size_t n) const;  // of its output

 private:
  std::string name_;
  std::filesystem::path log_file_;
  pid_t pid_ = -1;
  bool ended_ = false;
  int exit_code_ = -1;
  int signal_ = 0;
};

}  // namespace fusion_slam
