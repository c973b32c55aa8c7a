// A deputy without its network: takes orders, runs processes, says how they are. One thread; the
// one that makes it must live as long as the processes.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libs/process/load.hpp"
#include "libs/process/managed.hpp"
#include "libs/procman/allowed.hpp"
#include "libs/procman/deputy_core.hpp"

namespace fusion_slam {

struct DeputyOptions {
  std::string name;  // host name unless given
  std::string lcm_url;
  Allowed allowed;
  std::optional<std::pair<uid_t, gid_t>> user;  // commands run as; nothing: as the deputy
  std::string key_file;                         // empty: orders need no signature
  std::string log_folder;                       // empty: output goes to the network only
  double until_idle_s = 0.0;  // ends when it has had no commands for so long; 0: never
};

struct CommandOutput {
  std::string id;  // empty: the deputy speaks
  std::string text;
};

class Deputy {
 public:
  // oldest_utime_us as for DeputyCore.
  Deputy(const DeputyOptions& options, std::int64_t oldest_utime_us);
  ~Deputy();  // kills what still runs
  Deputy(const Deputy&) = delete;
  Deputy& operator=(const Deputy&) = delete;

  DeputyCore& core() { return core_; }

  // Does what is due: starts, signals, kills, reaps. True when a command's state has changed.
  bool work(std::int64_t now_us);
  // Measures CPU and memory; about once a second.
  void measure();
  DeputyInfo info(std::int64_t utime_us) const;
  // What commands printed since the last call, and what there is to say of them.
  std::vector<CommandOutput> take_output();

 private:
  struct Running {
    std::string id;
    int output = -1;
    std::size_t sent_bytes = 0;  // of this second's allowance
    std::size_t left_out_bytes = 0;
    std::int64_t second = 0;
  };
  void start(const std::string& id, std::int64_t now_us);
  bool reap_children(std::int64_t now_us);
  void read_all(std::int64_t now_us);
  void read_one(Running* running, std::int64_t now_us);
  void say(const std::string& id, const std::string& text);
  void append_to_log(const std::string& id, const std::string& text) const;

  DeputyOptions options_;
  DeputyCore core_;
  LoadMeter meter_;
  MachineLoad load_;
  std::map<pid_t, Running> running_;
  std::vector<CommandOutput> output_;
};

}  // namespace fusion_slam
