// procman's configuration files: commands, nested groups, scripts. Pure text: no network, no files
// but the one that is read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "libs/procman/command.hpp"

namespace fusion_slam {

// what(): "lab.cfg:12:5: expected ..., found ...".
class LabConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct LabCommand {
  CommandSpec spec;
  std::string deputy;
};

enum class TargetKind { kCommand, kGroup, kEverything };
enum class WaitFor { kNothing, kRunning, kStopped };

struct Target {
  TargetKind kind = TargetKind::kEverything;
  std::string name;  // command id, or "outer/inner"; empty for everything
};

struct ScriptAction {
  enum class Kind { kStart, kStop, kRestart, kWaitMs, kWaitStatus, kRunScript };
  Kind kind = Kind::kStart;
  Target target;
  WaitFor wait_for = WaitFor::kNothing;
  std::int64_t wait_ms = 0;
  std::string script;  // of kRunScript
};

struct Script {
  std::string name;
  std::vector<ScriptAction> actions;
};

struct LabConfig {
  std::vector<LabCommand> commands;  // ids unique, in the order of the file
  std::vector<Script> scripts;       // names unique; none runs itself
};

// `name` is the file's, for messages. Throws LabConfigError: syntax, attributes missing or out of
// range, ids given twice, scripts that name what does not exist.
LabConfig parse_lab_config(const std::string& text, const std::string& name);

// Throws LabConfigError also when the file can't be read or is larger than 4 MB.
LabConfig load_lab_config(const std::filesystem::path& file);

// A file that parses to the same configuration.
std::string to_text(const LabConfig& config);

// Indices into config.commands: a command's id, a group with all below it, or everything.
std::vector<std::size_t> select(const LabConfig& config, const Target& target);

// nullptr when there is none of that name.
const Script* find_script(const LabConfig& config, const std::string& name);

}  // namespace fusion_slam
