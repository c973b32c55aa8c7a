#include "libs/procman/lab_config.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <numeric>
#include <sstream>

namespace fusion_slam {
namespace {

constexpr std::uintmax_t kLargestFile_bytes = 4 << 20;

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (c == '\n') {
      result += "\\n";
    } else {
      result += c;
    }
  }
  return result + "\"";
}

// 7 as "7", 0.25 as "0.250".
std::string seconds(double value) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(value == std::floor(value) ? 0 : 3) << value;
  return out.str();
}

std::string to_text(const Target& target) {
  if (target.kind == TargetKind::kEverything) return "everything";
  return (target.kind == TargetKind::kCommand ? "cmd " : "group ") + quoted(target.name);
}

std::string to_text(WaitFor wait) {
  return wait == WaitFor::kRunning ? "\"running\"" : "\"stopped\"";
}

std::string to_text(const ScriptAction& action) {
  using Kind = ScriptAction::Kind;
  if (action.kind == Kind::kWaitMs) return "wait ms " + std::to_string(action.wait_ms);
  if (action.kind == Kind::kRunScript) return "run_script " + quoted(action.script);
  if (action.kind == Kind::kWaitStatus)
    return "wait " + to_text(action.target) + " status " + to_text(action.wait_for);
  const std::string verb = action.kind == Kind::kStart  ? "start "
                           : action.kind == Kind::kStop ? "stop "
                                                        : "restart ";
  return verb + to_text(action.target) +
         (action.wait_for == WaitFor::kNothing ? "" : " wait " + to_text(action.wait_for));
}

// "a/b": a and b. Empty parts count for nothing.
std::vector<std::string> parts(const std::string& group) {
  std::vector<std::string> result;
  std::istringstream in(group);
  for (std::string part; std::getline(in, part, '/');)
    if (!part.empty()) result.push_back(part);
  return result;
}

// procman reads whole seconds only, and no attribute `group`: the enclosing groups count.
void write(const LabCommand& command, std::ostringstream* out) {
  const CommandSpec& spec = command.spec;
  *out << "cmd " << quoted(spec.id) << " {\n  exec = " << quoted(spec.exec)
       << ";\n  deputy = " << quoted(command.deputy) << ";\n";
  if (spec.auto_respawn) *out << "  auto_respawn = \"true\";\n";
  *out << "  stop_signal = " << spec.stop_signal
       << ";\n  stop_time_allowed = " << seconds(spec.stop_time_allowed_s) << ";\n}\n";
}

bool is_below(const std::string& group, const std::string& outer) {
  return group == outer || group.rfind(outer + "/", 0) == 0;
}

}  // namespace

LabConfig load_lab_config(const std::filesystem::path& file) {
  std::error_code problem;
  const auto size_bytes = std::filesystem::file_size(file, problem);
  if (problem) throw LabConfigError("cannot read " + file.string() + ": " + problem.message());
  if (size_bytes > kLargestFile_bytes)
    throw LabConfigError(file.string() + " is larger than 4 MB: that is no lab configuration");
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return parse_lab_config(text.str(), file.string());
}

std::string to_text(const LabConfig& config) {
  std::ostringstream out;
  for (const LabCommand& command : config.commands) {
    const std::vector<std::string> groups = parts(command.spec.group);
    for (const std::string& group : groups) out << "group " << quoted(group) << " {\n";
    write(command, &out);
    for (std::size_t i = 0; i < groups.size(); ++i) out << "}\n";
  }
  for (const Script& script : config.scripts) {
    out << "script " << quoted(script.name) << " {\n";
    for (const ScriptAction& action : script.actions) out << "  " << to_text(action) << ";\n";
    out << "}\n";
  }
  return out.str();
}

std::vector<std::size_t> select(const LabConfig& config, const Target& target) {
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < config.commands.size(); ++i) {
    const CommandSpec& spec = config.commands[i].spec;
    const bool named = target.kind == TargetKind::kCommand ? spec.id == target.name
                                                           : is_below(spec.group, target.name);
    if (target.kind == TargetKind::kEverything || named) result.push_back(i);
  }
  return result;
}

const Script* find_script(const LabConfig& config, const std::string& name) {
  const auto it = std::find_if(config.scripts.begin(), config.scripts.end(),
                               [&](const Script& s) { return s.name == name; });
  return it == config.scripts.end() ? nullptr : &*it;
}

}  // namespace fusion_slam
