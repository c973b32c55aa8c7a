#include "procman/sheriff/tasks.hpp"

#include <algorithm>
#include <functional>
#include <iostream>
#include <set>

#include <unistd.h>

#include "libs/clock/clock.hpp"
#include "libs/procman/script_runner.hpp"
#include "libs/procman/status_table.hpp"
#include "procman/sheriff/local_deputy.hpp"
#include "procman/sheriff/log_lines.hpp"
#include "procman/sheriff/sheriff_process.hpp"

namespace fusion_slam {
namespace {

constexpr int kTurn_ms = 50;
constexpr int kDiscover_ms = 1300;  // deputies and other sheriffs speak once a second
constexpr int kAnswers_ms = 600;    // to PM_DISCOVER
constexpr std::int64_t kSettled_us = 700'000;

class Tasks {
 public:
  Tasks(const SheriffOptions& options, const std::atomic<bool>* stop)
      : options_(options),
        stop_(stop),
        config_(options.file.empty() ? LabConfig{} : load_lab_config(options.file)),
        ids_(selected()),
        sheriff_(options.lcm_url, options.key_file) {}

  int up() {
    prepare();
    for (const std::string& id : ids_) {
      const SheriffCommand& command = sheriff_.core().commands().at(id);
      if (command.actual && command.actual->pid > 0 &&
          command.actual->spec.exec != command.spec.exec)
        std::cerr << id << " runs with what it was started with: `restart` applies the new exec\n";
      sheriff_.core().start(id);
    }
    sheriff_.changed();
    return settle();
  }

  int restart() {
    prepare();
    for (const std::string& id : ids_) sheriff_.core().restart(id);
    sheriff_.changed();
    return settle();
  }

  int down() {
    prepare();
    for (const std::string& id : ids_) sheriff_.core().stop(id);
    sheriff_.changed();
    const bool stopped = wait([this] { return sheriff_.core().all(ids_, WaitFor::kStopped); });
    if (stopped) {
      for (const std::string& id : ids_) sheriff_.core().remove(id);
      sheriff_.changed();
      wait([this] {
        const auto& commands = sheriff_.core().commands();
        return std::none_of(ids_.begin(), ids_.end(),
                            [&](const std::string& id) { return commands.count(id) > 0; });
      });
      std::cerr << "all stopped\n";
      return 0;
    }
    show();
    std::cerr << "not all have stopped\n";
    return 1;
  }

  int run() {
    prepare();
    ScriptRunner script(config_, options_.script);
    std::string told;
    sheriff_.changed();
    while (!*stop_ && !script.step(&sheriff_.core(), steady_us())) {
      if (script.waiting_for() != told) {
        told = script.waiting_for();
        std::cerr << told << "\n";
        sheriff_.changed();
      }
      sheriff_.turn(10);
    }
    sheriff_.changed();
    for (int i = 0; i < 10; ++i) sheriff_.turn(kTurn_ms);
    show();
    return *stop_ ? 1 : 0;
  }

  int status() {
    sheriff_.core().load(config_);
    sheriff_.discover(kAnswers_ms);
    if (options_.watch) {
      watch();
      return 0;
    }
    show();
    return sheriff_.core().deputies().empty() ? 1 : 0;
  }

  int logs() {
    const std::set<std::string> wanted(ids_.begin(), ids_.end());
    LogLines lines;
    sheriff_.on_output(
        [&](const std::string& deputy, const std::string& id, const std::string& text) {
          if (id.empty() || wanted.count(id) > 0)
            std::cout << lines.add(deputy, id, text) << std::flush;
        });
    while (!*stop_) sheriff_.turn(kTurn_ms);
    std::cout << lines.rest() << std::flush;
    return 0;
  }

 private:
  std::vector<std::string> selected() const {
    std::vector<Target> targets;
    for (const std::string& name : options_.names) {
      const Target command{TargetKind::kCommand, name};
      const Target group{TargetKind::kGroup, name};
      if (select(config_, command).empty() && select(config_, group).empty())
        throw LabConfigError(options_.file + " has no command or group \"" + name + "\"");
      targets.push_back(select(config_, command).empty() ? group : command);
    }
    if (targets.empty()) targets.emplace_back();
    std::vector<std::string> ids;
    for (const Target& target : targets)
      for (const std::size_t i : select(config_, target))
        ids.push_back(config_.commands[i].spec.id);
    return ids;
  }

  // Finds the deputies, starts the local one where it is missing, and takes command.
  void prepare() {
    sheriff_.core().load(config_);
    sheriff_.discover(kDiscover_ms);
    sheriff_.take_command();
    const std::vector<std::string> missing = missing_deputies();
    if (std::count(missing.begin(), missing.end(), kLocalDeputy) > 0 &&
        options_.task != SheriffTask::kDown)
      std::cerr << "starting a deputy on this machine; it writes to "
                << start_local_deputy(options_.lcm_url, options_.key_file) << "\n";
    if (wait([this] { return missing_deputies().empty(); })) return;
    std::string names;
    for (const std::string& name : missing_deputies()) names += " " + name;
    std::string heard;
    for (const auto& [name, view] : sheriff_.core().deputies()) heard += " " + name;
    throw std::runtime_error("no deputy answers for:" + names +
                             ". Start there: fusion-slam lab deputy --name NAME (heard:" +
                             (heard.empty() ? " none" : heard) +
                             "; `fusion-slam doctor` tests the network)");
  }

  std::vector<std::string> missing_deputies() const {
    std::set<std::string> result;
    for (const std::string& id : ids_) {
      const std::string& deputy = sheriff_.core().commands().at(id).deputy;
      if (sheriff_.core().deputies().count(deputy) == 0) result.insert(deputy);
    }
    return {result.begin(), result.end()};
  }

  bool wait(const std::function<bool()>& condition) {
    const std::int64_t until_us = steady_us() + static_cast<std::int64_t>(1e6 * options_.timeout_s);
    while (!condition()) {
      if (*stop_ || steady_us() > until_us) return false;
      sheriff_.turn(kTurn_ms);
    }
    return true;
  }

  bool each_runs_or_has_run() const {
    return std::all_of(ids_.begin(), ids_.end(), [this](const std::string& id) {
      const CommandState state = sheriff_.core().commands().at(id).state();
      return state == CommandState::kRunning || state == CommandState::kStoppedWell;
    });
  }

  bool one_has_failed() const {
    return std::any_of(ids_.begin(), ids_.end(), [this](const std::string& id) {
      const SheriffCommand& command = sheriff_.core().commands().at(id);
      return command.state() == CommandState::kStoppedError && !command.spec.auto_respawn;
    });
  }

  int settle() {
    std::int64_t good_since_us = 0;
    wait([&] {
      if (one_has_failed()) return true;
      if (!each_runs_or_has_run())
        good_since_us = 0;
      else if (good_since_us == 0)
        good_since_us = steady_us();
      return good_since_us != 0 && steady_us() - good_since_us > kSettled_us;
    });
    if (options_.watch)
      watch();
    else
      show();
    for (const std::string& id : ids_) say_if_ignored(sheriff_.core().commands().at(id));
    return each_runs_or_has_run() ? 0 : 1;
  }

  // Its deputy is there and has not taken the orders; only the deputy knows why.
  void say_if_ignored(const SheriffCommand& command) const {
    if (command.state() != CommandState::kUnknown ||
        sheriff_.core().deputies().count(command.deputy) == 0)
      return;
    std::cerr << command.spec.id << ": deputy \"" << command.deputy << "\" has not taken the order "
              << "(its own log says why); does it want signed ones (--key"
              << (options_.key_file.empty() ? "" : ", another key") << ")?\n";
  }

  void watch() {
    const bool screen = isatty(STDOUT_FILENO) != 0;
    std::int64_t shown_us = 0;
    while (!*stop_) {
      sheriff_.turn(kTurn_ms);
      if (steady_us() - shown_us < 1'000'000) continue;
      shown_us = steady_us();
      std::cout << (screen ? "\033[H\033[2J" : "");
      show();
    }
  }

  void show() const {
    std::cout << (options_.json ? status_json(sheriff_.core(), steady_us())
                                : status_table(sheriff_.core(), steady_us()))
              << std::flush;
  }

  const SheriffOptions& options_;
  const std::atomic<bool>* stop_;
  LabConfig config_;
  std::vector<std::string> ids_;
  mutable SheriffProcess sheriff_;
};

}  // namespace

int run_sheriff(const SheriffOptions& options, const std::atomic<bool>* stop) {
  if (options.task == SheriffTask::kCheck) {
    std::cout << to_text(load_lab_config(options.file));
    return 0;
  }
  Tasks tasks(options, stop);
  switch (options.task) {
    case SheriffTask::kUp:
      return tasks.up();
    case SheriffTask::kDown:
      return tasks.down();
    case SheriffTask::kRestart:
      return tasks.restart();
    case SheriffTask::kLogs:
      return tasks.logs();
    case SheriffTask::kRun:
      return tasks.run();
    default:
      return tasks.status();
  }
}

}  // namespace fusion_slam
