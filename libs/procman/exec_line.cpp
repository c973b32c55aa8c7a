#include "libs/procman/exec_line.hpp"

#include <cctype>
#include <map>

namespace fusion_slam {
namespace {

bool begins_name(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool is_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

class ExecReader {
 public:
  ExecReader(const std::string& text, const Environment& environment)
      : text_(text), environment_(environment) {}

  std::optional<ExecLine> read(std::string* why) {
    while (next_word()) {
      if (!problem_.empty()) break;
      if (line_.argv.empty() && assignment_ > 0) {
        const std::string name = word_.substr(0, assignment_);
        line_.environment.emplace_back(name, word_.substr(assignment_ + 1));
        given_[name] = line_.environment.back().second;
      } else {
        line_.argv.push_back(word_);
      }
    }
    if (problem_.empty() && line_.argv.empty()) problem_ = "it names no program";
    if (problem_.empty()) return std::move(line_);
    if (why != nullptr) *why = problem_;
    return std::nullopt;
  }

 private:
  bool next_word() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
    if (at_ >= text_.size()) return false;
    word_.clear();
    assignment_ = 0;
    bool plain = true;  // so far only what a variable's name may hold
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) == 0) {
      const char c = text_[at_++];
      if (c == '=' && plain && !word_.empty() && assignment_ == 0) assignment_ = word_.size();
      if (word_.empty() ? !begins_name(c) : !is_name(c)) plain = false;
      if (c == '\'') {
        single_quoted();
      } else if (c == '"') {
        double_quoted();
      } else if (c == '\\') {
        if (at_ < text_.size()) word_ += text_[at_++];
      } else if (c == '$') {
        variable();
      } else {
        word_ += c;
      }
      if (!problem_.empty()) return true;
    }
    return true;
  }

  void single_quoted() {
    const std::size_t end = text_.find('\'', at_);
    if (end == std::string::npos) {
      problem_ = "a ' is not closed";
      return;
    }
    word_ += text_.substr(at_, end - at_);
    at_ = end + 1;
  }

  void double_quoted() {
    while (at_ < text_.size() && text_[at_] != '"') {
      const char c = text_[at_++];
      if (c == '$') {
        variable();
      } else if (c == '\\' && at_ < text_.size() &&
                 std::string("\"\\$`").find(text_[at_]) != std::string::npos) {
        word_ += text_[at_++];
      } else {
        word_ += c;
      }
    }
    if (at_ >= text_.size()) problem_ = "a \" is not closed";
    ++at_;
  }

  void variable() {
    const bool braced = at_ < text_.size() && text_[at_] == '{';
    const std::size_t begin = at_ + (braced ? 1 : 0);
    std::size_t end = begin;
    if (end < text_.size() && begins_name(text_[end]))
      while (end < text_.size() && is_name(text_[end])) ++end;
    const bool open = braced && (end >= text_.size() || text_[end] != '}');
    if (end == begin || open) {  // $$, ${x:-1}: for a shell that is run
      word_ += '$';
      return;
    }
    const std::string name = text_.substr(begin, end - begin);
    const std::size_t after = end + (braced ? 1 : 0);
    const auto mine = given_.find(name);
    const std::string as_it_stands = "$" + text_.substr(at_, after - at_);
    at_ = after;
    word_ += mine != given_.end() ? mine->second : environment_(name).value_or(as_it_stands);
  }

  const std::string& text_;
  const Environment& environment_;
  std::size_t at_ = 0;
  std::string word_;
  std::size_t assignment_ = 0;  // where the word's = stands, 0: it assigns nothing
  std::string problem_;
  std::map<std::string, std::string> given_;
  ExecLine line_;
};

}  // namespace

std::optional<ExecLine> parse_exec_line(const std::string& exec, const Environment& environment,
                                        std::string* why) {
  return ExecReader(exec, environment).read(why);
}

}  // namespace fusion_slam
