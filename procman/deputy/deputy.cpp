#include "procman/deputy/deputy.hpp"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <sys/wait.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

constexpr std::size_t kRead_bytes = 16 << 10;        // of a command, at a time
constexpr std::size_t kPerSecond_bytes = 128 << 10;  // of a command, onto the network

std::optional<std::string> from_environment(const std::string& name) {
  const char* value = std::getenv(name.c_str());
  return value == nullptr ? std::nullopt : std::optional<std::string>(value);
}

std::string file_name(std::string id) {
  for (char& c : id)
    if (c == '/' || c == '\0') c = '_';
  return (id.empty() || id[0] == '.' ? "_" + id : id) + ".log";
}

}  // namespace

Deputy::Deputy(const DeputyOptions& options, std::int64_t oldest_utime_us)
    : options_(options), core_(options.name, oldest_utime_us) {
  adopt_orphans();
  measure();
}

Deputy::~Deputy() {
  for (const auto& [pid, running] : running_) {
    kill(-pid, SIGKILL);
    waitpid(pid, nullptr, 0);
    close(running.output);
  }
}

void Deputy::say(const std::string& id, const std::string& text) {
  append_to_log(id, text);
  output_.push_back({id, text});
}

void Deputy::append_to_log(const std::string& id, const std::string& text) const {
  if (options_.log_folder.empty()) return;
  const auto path =
      std::filesystem::path(options_.log_folder) / file_name(id.empty() ? "procman-deputy" : id);
  std::ofstream(path, std::ios::app) << text;
}

void Deputy::start(const std::string& id, std::int64_t now_us) {
  CommandMachine& machine = *core_.find(id);
  std::string why;
  const auto line = parse_exec_line(machine.status().spec.exec, from_environment, &why);
  const std::string path =
      line ? find_allowed(options_.allowed, *line, from_environment("PATH").value_or(""), &why)
                 .string()
           : "";
  if (!path.empty()) {
    if (const auto spawned = spawn({path, line->argv, line->environment, options_.user}, &why)) {
      machine.started(spawned->pid, now_us);
      Running& running = running_[spawned->pid];
      running.id = id;
      running.output = spawned->output;
      return;
    }
  }
  machine.could_not_start(now_us);
  say(id, "not started: " + why + "\n");
}

bool Deputy::work(std::int64_t now_us) {
  read_all(now_us);
  bool changed = reap_children(now_us);
  for (const DeputyCore::Step& step : core_.steps(now_us)) {
    changed = true;
    const CommandStatus status = core_.find(step.id)->status();
    switch (step.action) {
      case CommandMachine::Action::kStart:
        start(step.id, now_us);
        break;
      case CommandMachine::Action::kSignal:
        kill(-status.pid, status.spec.stop_signal);
        kill(-status.pid, SIGCONT);  // one that was stopped would not hear it
        break;
      case CommandMachine::Action::kKill:
        say(step.id, "did not stop in time: killed\n");
        kill(-status.pid, SIGKILL);
        break;
      case CommandMachine::Action::kNothing:
        break;
    }
  }
  return changed;
}

bool Deputy::reap_children(std::int64_t now_us) {
  bool changed = false;
  for (const Reaped& reaped : reap()) {
    const auto it = running_.find(reaped.pid);
    if (it == running_.end()) continue;  // an orphan that we adopted
    Running& running = it->second;
    kill(-reaped.pid, SIGKILL);  // what it left behind in its group
    read_one(&running, now_us);
    if (WIFSIGNALED(reaped.wait_status))
      say(running.id, std::string("ended by signal ") +
                          std::to_string(WTERMSIG(reaped.wait_status)) + " (" +
                          strsignal(WTERMSIG(reaped.wait_status)) + ")\n");
    close(running.output);
    if (CommandMachine* machine = core_.find(running.id); machine != nullptr)
      machine->exited(reaped.wait_status, now_us);
    meter_.forget(reaped.pid);
    running_.erase(it);
    changed = true;
  }
  return changed;
}

void Deputy::read_all(std::int64_t now_us) {
  for (auto& [pid, running] : running_) read_one(&running, now_us);
}

void Deputy::read_one(Running* running, std::int64_t now_us) {
  bool ended = false;
  std::string text = read_output(running->output, kRead_bytes, &ended);
  if (now_us / 1'000'000 != running->second) {
    running->second = now_us / 1'000'000;
    running->sent_bytes = 0;
    if (running->left_out_bytes > 0)
      output_.push_back({running->id, "[" + std::to_string(running->left_out_bytes) +
                                          " bytes left out: more than 128 kB a second]\n"});
    running->left_out_bytes = 0;
  }
  if (text.empty()) return;
  append_to_log(running->id, text);
  std::replace(text.begin(), text.end(), '\0', '?');  // LCM's strings end there
  if (running->sent_bytes + text.size() > kPerSecond_bytes) {
    running->left_out_bytes += text.size();
    return;
  }
  running->sent_bytes += text.size();
  output_.push_back({running->id, std::move(text)});
}

void Deputy::measure() {
  meter_.sample();
  const MemoryState memory = memory_state();
  load_ = {meter_.cpu_load(), memory.total_bytes, memory.free_bytes, memory.swap_total_bytes,
           memory.swap_free_bytes};
  for (const auto& [pid, running] : running_) {
    CommandMachine* machine = core_.find(running.id);
    const auto load = meter_.process(pid);
    if (machine != nullptr && load)
      machine->set_load(load->cpu_usage, load->vsize_bytes, load->rss_bytes);
  }
}

DeputyInfo Deputy::info(std::int64_t utime_us) const {
  DeputyInfo info;
  info.utime_us = utime_us;
  info.deputy = options_.name;
  info.load = load_;
  for (const auto& [id, machine] : core_.commands()) info.commands.push_back(machine.status());
  return info;
}

std::vector<CommandOutput> Deputy::take_output() { return std::exchange(output_, {}); }

}  // namespace fusion_slam
