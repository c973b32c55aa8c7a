#include "procman/sheriff/options.hpp"

#include <cstdlib>

#include <CLI/CLI.hpp>

namespace fusion_slam {

std::optional<SheriffOptions> parse_sheriff_options(int argc, char** argv, int* exit_code) {
  CLI::App app(
      "procman-sheriff (fusion-slam lab): starts, stops and watches the processes of a lab by "
      "orders to the deputies on its machines. Returns 0 when all is as wanted, 1 when not, 2 for "
      "wrong usage.",
      "fusion-slam lab");
  SheriffOptions options;
  if (const char* key = std::getenv("FUSION_SLAM_KEY_FILE")) options.key_file = key;
  app.add_option("--lcm-url", options.lcm_url,
                 "LCM network (default: LCM_DEFAULT_URL, else LCM's own)");
  app.add_option("--key", options.key_file,
                 "sign orders with the key in this file (default: FUSION_SLAM_KEY_FILE)");
  app.require_subcommand(1);
  app.fallthrough();
  const auto command = [&](const char* name, const char* help, SheriffTask task) {
    CLI::App* sub = app.add_subcommand(name, help);
    sub->callback([&options, task] { options.task = task; });
    return sub;
  };
  const auto file_of = [&](CLI::App* sub) {
    return sub->add_option("FILE", options.file, "lab configuration, see config/labs");
  };
  const auto names_of = [&](CLI::App* sub) {
    sub->add_option("NAME", options.names, "commands and groups; none: all of the file");
  };
  const auto timeout_of = [&](CLI::App* sub) {
    sub->add_option("--timeout", options.timeout_s, "seconds to wait")
        ->check(CLI::Range(0.1, 86400.0))
        ->capture_default_str();
  };
  CLI::App* up = command("up", "start what does not run", SheriffTask::kUp);
  file_of(up)->required();
  names_of(up);
  timeout_of(up);
  up->add_flag("--watch", options.watch,
               "stay, show the status, and start all again on a machine that comes back");
  CLI::App* down = command("down", "stop, and make the deputies forget", SheriffTask::kDown);
  file_of(down)->required();
  names_of(down);
  timeout_of(down);
  CLI::App* restart = command("restart", "stop and start again", SheriffTask::kRestart);
  file_of(restart)->required();
  names_of(restart);
  timeout_of(restart);
  CLI::App* status = command("status", "what runs where, and how", SheriffTask::kStatus);
  file_of(status);
  status->add_flag("--watch", options.watch, "go on until Ctrl-C");
  status->add_flag("--json", options.json, "JSON instead of a table");
  CLI::App* logs = command("logs", "what processes print, from now on", SheriffTask::kLogs);
  file_of(logs)->required();
  names_of(logs);
  CLI::App* run = command("run", "run a script of the configuration", SheriffTask::kRun);
  file_of(run)->required();
  run->add_option("SCRIPT", options.script, "its name")->required();
  CLI::App* check =
      command("check", "read the configuration, print it in order", SheriffTask::kCheck);
  file_of(check)->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error) == 0 ? 0 : 2;
    return std::nullopt;
  }
  return options;
}

}  // namespace fusion_slam
