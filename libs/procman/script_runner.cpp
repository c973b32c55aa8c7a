#include "libs/procman/script_runner.hpp"

namespace fusion_slam {
namespace {

using Kind = ScriptAction::Kind;

std::string describe(const Target& target) {
  if (target.kind == TargetKind::kEverything) return "everything";
  return (target.kind == TargetKind::kCommand ? "cmd \"" : "group \"") + target.name + "\"";
}

}  // namespace

std::string describe(const ScriptAction& action) {
  const std::string state = action.wait_for == WaitFor::kRunning ? "\"running\"" : "\"stopped\"";
  switch (action.kind) {
    case Kind::kWaitMs:
      return "wait ms " + std::to_string(action.wait_ms);
    case Kind::kRunScript:
      return "run_script \"" + action.script + "\"";
    case Kind::kWaitStatus:
      return "wait " + describe(action.target) + " status " + state;
    default:
      break;
  }
  const std::string verb = action.kind == Kind::kStart  ? "start "
                           : action.kind == Kind::kStop ? "stop "
                                                        : "restart ";
  return verb + describe(action.target) +
         (action.wait_for == WaitFor::kNothing ? "" : " wait " + state);
}

ScriptRunner::ScriptRunner(LabConfig config, const std::string& script)
    : config_(std::move(config)) {
  const Script* found = find_script(config_, script);
  if (found == nullptr) throw LabConfigError("the configuration has no script \"" + script + "\"");
  stack_.emplace_back(found, 0);
}

std::vector<std::string> ScriptRunner::ids(const Target& target) const {
  std::vector<std::string> result;
  for (const std::size_t i : select(config_, target)) result.push_back(config_.commands[i].spec.id);
  return result;
}

void ScriptRunner::order(const ScriptAction& action, SheriffCore* sheriff) const {
  for (const std::string& id : ids(action.target)) {
    if (action.kind == Kind::kStart) sheriff->start(id);
    if (action.kind == Kind::kStop) sheriff->stop(id);
    if (action.kind == Kind::kRestart) sheriff->restart(id);
  }
}

bool ScriptRunner::is_over(const ScriptAction& action, const SheriffCore& sheriff,
                           std::int64_t now_us) const {
  if (action.kind == Kind::kWaitMs) return now_us - since_us_ >= action.wait_ms * 1000;
  return sheriff.all(ids(action.target), action.wait_for);
}

bool ScriptRunner::step(SheriffCore* sheriff, std::int64_t now_us) {
  while (!stack_.empty()) {
    auto& [script, at] = stack_.back();
    if (at >= script->actions.size()) {
      stack_.pop_back();
      continue;
    }
    const ScriptAction& action = script->actions[at];
    if (action.kind == Kind::kRunScript) {
      ++at;
      stack_.emplace_back(find_script(config_, action.script), 0);
      continue;
    }
    if (!ordered_) {
      ordered_ = true;
      since_us_ = now_us;
      order(action, sheriff);
    }
    waiting_for_ = describe(action);
    if (!is_over(action, *sheriff, now_us)) return false;
    ordered_ = false;
    ++at;
  }
  waiting_for_.clear();
  return true;
}

}  // namespace fusion_slam
