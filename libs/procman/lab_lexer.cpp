#include "libs/procman/lab_lexer.hpp"

#include <cctype>

#include "libs/procman/lab_config.hpp"

namespace fusion_slam {
namespace {

bool is_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '.' ||
         c == '+';
}

class LabLexer {
 public:
  LabLexer(const std::string& text, const std::string& name) : text_(text), name_(name) {}

  std::vector<LabToken> tokens() {
    std::vector<LabToken> result;
    for (;;) {
      skip_space();
      result.push_back(next());
      if (result.back().kind == LabToken::Kind::kEnd) return result;
    }
  }

 private:
  bool done() const { return at_ >= text_.size(); }
  char take() {
    const char c = text_[at_++];
    column_ = c == '\n' ? 1 : column_ + 1;
    line_ += c == '\n' ? 1 : 0;
    return c;
  }

  void skip_space() {
    while (!done()) {
      if (text_[at_] == '#') {
        while (!done() && text_[at_] != '\n') take();
      } else if (std::isspace(static_cast<unsigned char>(text_[at_])) != 0) {
        take();
      } else {
        return;
      }
    }
  }

  LabToken next() {
    LabToken token;
    token.line = line_;
    token.column = column_;
    if (done()) return token;
    const char c = text_[at_];
    if (c == '"' || c == '\'') {
      token.kind = LabToken::Kind::kString;
      token.text = quoted(token);
    } else if (c == '{' || c == '}' || c == '=' || c == ';') {
      token.kind = LabToken::Kind::kSign;
      token.text = take();
    } else if (is_word(c)) {
      while (!done() && is_word(text_[at_])) token.text += take();
      const bool number = token.text.find_first_not_of("0123456789.+-") == std::string::npos;
      token.kind = number ? LabToken::Kind::kNumber : LabToken::Kind::kWord;
    } else {
      fail(token, "a character that has no meaning here (byte " +
                      std::to_string(static_cast<unsigned char>(c)) + ")");
    }
    return token;
  }

  std::string quoted(const LabToken& token) {
    std::string result;
    const char quote = take();
    for (;;) {
      if (done() || text_[at_] == '\n') fail(token, "this string has no closing quote on its line");
      char c = take();
      if (c == quote) return result;
      if (c == '\0') fail(token, "a string can't hold a zero byte");
      if (c == '\\') {
        if (done() || text_[at_] == '\n')
          fail(token, "this string has no closing quote on its line");
        const char escaped = take();
        if (escaped == '\0') fail(token, "a string can't hold a zero byte");
        c = escaped == 'n' ? '\n' : escaped == 't' ? '\t' : escaped == 'r' ? '\r' : escaped;
      }
      result += c;
    }
  }

  [[noreturn]] void fail(const LabToken& token, const std::string& what) const {
    throw LabConfigError(name_ + ":" + std::to_string(token.line) + ":" +
                         std::to_string(token.column) + ": " + what);
  }

  const std::string& text_;
  const std::string& name_;
  std::size_t at_ = 0;
  int line_ = 1;
  int column_ = 1;
};

}  // namespace

std::vector<LabToken> tokenise_lab(const std::string& text, const std::string& name) {
  return LabLexer(text, name).tokens();
}

}  // namespace fusion_slam
