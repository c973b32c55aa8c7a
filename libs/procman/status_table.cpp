#include "libs/procman/status_table.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <tuple>
#include <vector>

#include <nlohmann/json.hpp>
#include <sys/wait.h>

namespace fusion_slam {
namespace {

constexpr std::int64_t kSilent_us = 3'500'000;  // three PM_INFO missing

std::string with_digits(double value, int digits, const char* unit) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f %s", digits, value, unit);
  return text;
}

std::string megabytes(std::int64_t bytes) {
  return with_digits(static_cast<double>(bytes) / 1e6, 0, "MB");
}
std::string percent(double fraction) { return with_digits(100.0 * fraction, 0, "%"); }

using Rows = std::vector<std::vector<std::string>>;

std::string aligned(const Rows& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      std::string cell = row[i];
      cell.resize(widths[i], ' ');
      line += cell + "  ";
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string last_heard(const DeputyView& view, std::int64_t now_us) {
  const double age_s = 1e-6 * static_cast<double>(now_us - view.heard_us);
  if (now_us - view.heard_us > kSilent_us) return "SILENT for " + with_digits(age_s, 0, "s");
  return with_digits(age_s, 1, "s ago");
}

}  // namespace

std::string how_it_ended(const CommandStatus& status) {
  if (status.pid != 0 || (status.actual_runid == 0 && status.exit_code == 0)) return "";
  if (WIFSIGNALED(status.exit_code)) {
    const int number = WTERMSIG(status.exit_code);
    const char* name = strsignal(number);
    return "signal " + std::to_string(number) + " (" + (name != nullptr ? name : "?") + ")";
  }
  const int code = WEXITSTATUS(status.exit_code);
  return code == 127 ? "could not be started (see its output)"
                     : "exit code " + std::to_string(code);
}

std::string status_table(const SheriffCore& sheriff, std::int64_t now_us) {
  Rows machines{{"DEPUTY", "HEARD", "CPU", "MEMORY FREE"}};
  for (const auto& [name, view] : sheriff.deputies())
    machines.push_back({name, last_heard(view, now_us), percent(view.load.cpu_load),
                        megabytes(view.load.memory_free_bytes) + " of " +
                            megabytes(view.load.memory_total_bytes)});
  Rows commands{{"DEPUTY", "GROUP", "COMMAND", "STATE", "PID", "CPU", "MEMORY", "ENDED"}};
  for (const auto& [id, command] : sheriff.commands()) {
    std::vector<std::string> row{
        command.deputy, command.spec.group, id, to_string(command.state()), "", "", "", ""};
    const auto deputy = sheriff.deputies().find(command.deputy);
    if (deputy == sheriff.deputies().end()) row[3] = "no such deputy heard";
    if (command.actual) {
      const bool runs = command.actual->pid > 0;
      if (runs) row[4] = std::to_string(command.actual->pid);
      if (runs) row[5] = percent(command.actual->cpu_usage);
      if (runs) row[6] = megabytes(command.actual->rss_bytes);
      row[7] = how_it_ended(*command.actual);
    }
    commands.push_back(std::move(row));
  }
  std::stable_sort(commands.begin() + 1, commands.end(), [](const auto& a, const auto& b) {
    return std::tie(a[0], a[1], a[2]) < std::tie(b[0], b[1], b[2]);
  });
  const std::string top = sheriff.deputies().empty() ? "no deputy heard\n" : aligned(machines);
  return top + "\n" + (commands.size() == 1 ? "no commands\n" : aligned(commands));
}

std::string status_json(const SheriffCore& sheriff, std::int64_t now_us) {
  nlohmann::ordered_json json{{"deputies", nlohmann::json::array()},
                              {"commands", nlohmann::json::array()}};
  for (const auto& [name, view] : sheriff.deputies())
    json["deputies"].push_back({{"name", name},
                                {"heard_s_ago", 1e-6 * static_cast<double>(now_us - view.heard_us)},
                                {"cpu_load", view.load.cpu_load},
                                {"memory_total_bytes", view.load.memory_total_bytes},
                                {"memory_free_bytes", view.load.memory_free_bytes}});
  for (const auto& [id, command] : sheriff.commands()) {
    nlohmann::ordered_json entry{{"name", id},
                                 {"deputy", command.deputy},
                                 {"group", command.spec.group},
                                 {"exec", command.spec.exec},
                                 {"state", to_string(command.state())}};
    if (command.actual) {
      entry["pid"] = command.actual->pid;
      entry["runid"] = command.actual->actual_runid;
      entry["cpu_usage"] = command.actual->cpu_usage;
      entry["rss_bytes"] = command.actual->rss_bytes;
      entry["vsize_bytes"] = command.actual->vsize_bytes;
      entry["ended"] = how_it_ended(*command.actual);
    }
    json["commands"].push_back(std::move(entry));
  }
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace fusion_slam
