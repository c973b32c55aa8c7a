// Processes of a deputy: each in a session of its own, its output on a pseudo-terminal so that it
// comes line by line as on a screen.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <sys/types.h>

namespace fusion_slam {

struct SpawnRequest {
  std::string program;                                           // path
  std::vector<std::string> argv;                                 // argv[0] included
  std::vector<std::pair<std::string, std::string>> environment;  // added to ours
  // To become, when this process is root and wants to; nothing: stays who it is.
  std::optional<std::pair<uid_t, gid_t>> user;
};

struct Spawned {
  pid_t pid = 0;
  int output = -1;  // our end of the terminal, not blocking; the caller closes it
};

// Starts it as leader of a session and process group of its own; it gets SIGKILL when this process
// ends in any way. Nothing and `why` when it can't be started at all; when only the last step fails
// it prints the reason and ends with exit code 127. Call it from a thread that lives as long as the
// process does (prctl(2), PR_SET_PDEATHSIG).
std::optional<Spawned> spawn(const SpawnRequest& request, std::string* why);

// Orphans of our children become ours, so that reap() finds them. Once a process.
void adopt_orphans();

struct Reaped {
  pid_t pid = 0;
  int wait_status = 0;
};
// Children, and orphans, that have ended; never blocks.
std::vector<Reaped> reap();

// What waits to be read, at most `most_bytes`; sets *ended when nothing more will come.
std::string read_output(int output, std::size_t most_bytes, bool* ended);

}  // namespace fusion_slam
