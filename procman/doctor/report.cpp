#include "procman/doctor/report.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace fusion_slam {
namespace {

std::string to_string(CheckState state) {
  switch (state) {
    case CheckState::kGood:
      return "good";
    case CheckState::kWarning:
      return "warning";
    case CheckState::kFault:
      return "fault";
  }
  return "";
}

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(width, text.size()), ' ');
  return text;
}

}  // namespace

bool has_fault(const std::vector<CheckResult>& results) {
  return std::any_of(results.begin(), results.end(),
                     [](const CheckResult& r) { return r.state == CheckState::kFault; });
}

std::string text_report(const std::vector<CheckResult>& results) {
  std::string text;
  std::ptrdiff_t n_faults = 0;
  for (const CheckResult& result : results) {
    n_faults += result.state == CheckState::kFault ? 1 : 0;
    const std::string state =
        result.state == CheckState::kFault ? "FAULT" : to_string(result.state);
    text += padded(state, 9) + padded(result.name, 16) + result.found + "\n";
    if (!result.command.empty()) text += padded("", 9) + "mend it with:   " + result.command + "\n";
  }
  return text + (n_faults == 0 ? "no faults\n"
                               : std::to_string(n_faults) +
                                     " faults; commands that change the system need root (sudo), "
                                     "and those of `sysctl -w` and "
                                     "`ip` last until the next boot\n");
}

std::string json_report(const std::vector<CheckResult>& results) {
  nlohmann::json list = nlohmann::json::array();
  for (const CheckResult& result : results) {
    list.push_back({{"name", result.name},
                    {"state", to_string(result.state)},
                    {"found", result.found},
                    {"command", result.command}});
  }
  return list.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string commands(const std::vector<CheckResult>& results) {
  std::string text;
  for (const CheckResult& result : results) {
    if (result.state == CheckState::kFault && !result.command.empty())
      text += result.command + "\n";
  }
  return text;
}

}  // namespace fusion_slam
