// The grammar of a procman configuration file, by recursive descent.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <set>

#include "libs/procman/lab_config.hpp"
#include "libs/procman/lab_lexer.hpp"

namespace fusion_slam {
namespace {

using Token = LabToken;
using Kind = LabToken::Kind;

constexpr int kDeepestGroup = 32;

class LabParser {
 public:
  LabParser(const std::string& text, const std::string& name)
      : name_(name), tokens_(tokenise_lab(text, name)) {}

  LabConfig parse() {
    while (peek().kind != Kind::kEnd) element("", 0);
    check_scripts();
    return std::move(config_);
  }

 private:
  const Token& peek() const { return tokens_[at_]; }
  const Token& take() { return tokens_[at_ + 1 < tokens_.size() ? at_++ : at_]; }

  [[noreturn]] void fail(const Token& token, const std::string& what) const {
    throw LabConfigError(name_ + ":" + std::to_string(token.line) + ":" +
                         std::to_string(token.column) + ": " + what);
  }
  [[noreturn]] void unexpected(const std::string& wanted) const {
    const Token& token = peek();
    fail(token, "expected " + wanted + ", found " +
                    (token.kind == Kind::kEnd ? "the end of the file" : "`" + token.text + "`"));
  }

  bool accept(const char* word) {
    const bool same =
        (peek().kind == Kind::kWord || peek().kind == Kind::kSign) && peek().text == word;
    if (same) take();
    return same;
  }
  void expect(const char* sign) {
    if (!accept(sign)) unexpected(std::string("`") + sign + "`");
  }
  std::string string(const std::string& wanted) {
    if (peek().kind != Kind::kString) unexpected(wanted + " in quotes");
    return take().text;
  }
  double number(const std::string& wanted, double least, double most) {
    const Token token = peek();
    if (token.kind != Kind::kNumber && token.kind != Kind::kString) unexpected(wanted);
    char* end = nullptr;
    const double value = std::strtod(token.text.c_str(), &end);
    if (token.text.empty() || *end != '\0' || !(value >= least && value <= most))
      fail(token, wanted + " must be a number from " + std::to_string(static_cast<long>(least)) +
                      " to " + std::to_string(static_cast<long>(most)) + ", not `" + token.text +
                      "`");
    take();
    return value;
  }

  void element(const std::string& group, int depth) {
    if (accept("cmd")) return command(group);
    if (accept("group")) return nested_group(group, depth);
    if (depth == 0 && accept("script")) return script();
    unexpected(depth == 0 ? "`cmd`, `group` or `script`" : "`cmd`, `group` or `}`");
  }

  void nested_group(const std::string& outer, int depth) {
    const Token at = peek();
    const std::string inner = string("the group's name");
    if (inner.empty() || inner.find('/') != std::string::npos)
      fail(at,
           "a group's name must not be empty or hold a `/`: that joins the names of nested groups");
    if (depth >= kDeepestGroup) fail(at, "groups are nested deeper than 32");
    expect("{");
    std::string name = outer.empty() ? inner : outer + "/";
    if (!outer.empty()) name += inner;
    while (!accept("}")) element(name, depth + 1);
  }

  void command(const std::string& group) {
    const Token at = peek();
    LabCommand command;
    command.spec.id = string("the command's name");
    command.spec.group = group;
    if (command.spec.id.empty()) fail(at, "a command's name must not be empty");
    if (!ids_.insert(command.spec.id).second)
      fail(at, "a second command is called \"" + command.spec.id + "\": give each its own name");
    expect("{");
    while (!accept("}")) attribute(&command);
    if (command.spec.exec.empty()) fail(at, "\"" + command.spec.id + "\" lacks `exec = \"...\";`");
    if (command.deputy.empty()) fail(at, "\"" + command.spec.id + "\" lacks `deputy = \"...\";`");
    config_.commands.push_back(std::move(command));
  }

  void attribute(LabCommand* command) {
    const Token name = peek();
    if (name.kind != Kind::kWord) unexpected("an attribute or `}`");
    take();
    expect("=");
    const Token at = peek();
    if (name.text == "exec") {
      command->spec.exec = string("what to run");
    } else if (name.text == "deputy" || name.text == "host") {  // host: what older files say
      command->deputy = string("the deputy's name");
    } else if (name.text == "group") {
      command->spec.group = string("the group's name");
    } else if (name.text == "auto_respawn") {
      std::string value = peek().kind == Kind::kWord ? take().text : string("true or false");
      for (char& c : value) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      const bool yes = value == "true" || value == "yes";
      if (!yes && value != "false" && value != "no")
        fail(at, "auto_respawn is \"true\" or \"false\"");
      command->spec.auto_respawn = yes;
    } else if (name.text == "stop_signal") {
      command->spec.stop_signal = static_cast<int>(number("stop_signal", 1, 64));
    } else if (name.text == "stop_time_allowed") {
      command->spec.stop_time_allowed_s = number("stop_time_allowed (seconds)", 0, 3600);
    } else {
      fail(name,
           "no attribute `" + name.text +
               "`: there are exec, deputy, group, auto_respawn, stop_signal, stop_time_allowed");
    }
    expect(";");
  }

  void script() {
    const Token at = peek();
    Script script;
    script.name = string("the script's name");
    if (find_script(config_, script.name) != nullptr)
      fail(at, "a second script is called \"" + script.name + "\"");
    expect("{");
    while (!accept("}")) script.actions.push_back(action());
    config_.scripts.push_back(std::move(script));
  }

  Target target() {
    const Token at = peek();
    Target target;
    if (accept("cmd")) {
      target = {TargetKind::kCommand, string("the command's name")};
    } else if (accept("group")) {
      target = {TargetKind::kGroup, string("the group's name")};
    } else if (!accept("everything")) {
      unexpected("`cmd`, `group` or `everything`");
    }
    targets_.push_back({at, target});
    return target;
  }

  WaitFor status() {
    const Token at = peek();
    const std::string text = string("running or stopped");
    if (text != "running" && text != "stopped") fail(at, "wait for \"running\" or \"stopped\"");
    return text == "running" ? WaitFor::kRunning : WaitFor::kStopped;
  }

  ScriptAction action() {
    ScriptAction action;
    const Token at = peek();
    if (accept("wait")) {
      action.kind = ScriptAction::Kind::kWaitMs;
      if (accept("ms")) {
        action.wait_ms = static_cast<std::int64_t>(number("milliseconds", 0, 86'400'000));
      } else {
        action.kind = ScriptAction::Kind::kWaitStatus;
        action.target = target();
        expect("status");
        action.wait_for = status();
      }
    } else if (accept("run_script")) {
      action.kind = ScriptAction::Kind::kRunScript;
      action.script = string("the script's name");
      calls_.push_back({at, action.script});
    } else if (accept("start") || accept("stop") || accept("restart")) {
      action.kind = at.text == "start"  ? ScriptAction::Kind::kStart
                    : at.text == "stop" ? ScriptAction::Kind::kStop
                                        : ScriptAction::Kind::kRestart;
      action.target = target();
      if (accept("wait")) action.wait_for = status();
    } else {
      unexpected("`start`, `stop`, `restart`, `wait`, `run_script` or `}`");
    }
    expect(";");
    return action;
  }

  void check_scripts() const {
    for (const auto& [at, target] : targets_)
      if (target.kind != TargetKind::kEverything && select(config_, target).empty())
        fail(at, std::string("there is no ") +
                     (target.kind == TargetKind::kCommand ? "command" : "group") + " \"" +
                     target.name + "\"");
    for (const auto& [at, name] : calls_)
      if (find_script(config_, name) == nullptr) fail(at, "there is no script \"" + name + "\"");
    for (const Script& script : config_.scripts) check_calls(script);
  }

  // Walks what a script calls, breadth first: it must not come back to itself.
  void check_calls(const Script& script) const {
    std::set<std::string> seen;
    std::vector<std::string> open{script.name};
    while (!open.empty()) {
      const Script* current = find_script(config_, open.back());
      open.pop_back();
      for (const ScriptAction& action : current->actions) {
        if (action.kind != ScriptAction::Kind::kRunScript) continue;
        if (action.script == script.name)
          throw LabConfigError(name_ + ": script \"" + script.name +
                               "\" would run itself for ever");
        if (seen.insert(action.script).second) open.push_back(action.script);
      }
    }
  }

  const std::string& name_;
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
  LabConfig config_;
  std::set<std::string> ids_;
  std::vector<std::pair<Token, Target>> targets_;     // to be looked up when all is read
  std::vector<std::pair<Token, std::string>> calls_;  // likewise
};

}  // namespace

LabConfig parse_lab_config(const std::string& text, const std::string& name) {
  return LabParser(text, name).parse();
}

}  // namespace fusion_slam
