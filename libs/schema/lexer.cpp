#include "libs/schema/lexer.hpp"

#include <cctype>
#include <stdexcept>

namespace fusion_slam {
namespace {

bool is_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
}
bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

}  // namespace

std::vector<LcmToken> lcm_tokens(const std::string& file, const std::string& text) {
  std::vector<LcmToken> tokens;
  int line = 1;
  std::size_t at = 0;
  const auto fail = [&](const std::string& what) {
    throw std::runtime_error(file + ":" + std::to_string(line) + ": " + what);
  };
  while (at < text.size()) {
    const char c = text[at];
    if (c == '\n') {
      ++line;
      ++at;
    } else if (is_space(c)) {
      ++at;
    } else if (text.compare(at, 2, "//") == 0) {
      while (at < text.size() && text[at] != '\n') ++at;
    } else if (text.compare(at, 2, "/*") == 0) {
      const std::size_t end = text.find("*/", at + 2);
      if (end == std::string::npos) fail("the comment that starts here never ends: add */");
      for (; at < end + 2; ++at) line += text[at] == '\n' ? 1 : 0;
    } else if (is_word(c) || c == '-' || c == '+') {
      const std::size_t begin = at++;
      // A number may hold a sign behind its exponent: 1.5e-3.
      const bool number = !std::isalpha(static_cast<unsigned char>(c)) && c != '_';
      const bool hex = number && text.compare(begin, 2, "0x") == 0;
      while (at < text.size() &&
             (is_word(text[at]) || (number && !hex && (text[at] == '-' || text[at] == '+') &&
                                    (text[at - 1] == 'e' || text[at - 1] == 'E')))) {
        ++at;
      }
      tokens.push_back({text.substr(begin, at - begin), line});
    } else if (std::string("{}[];,=").find(c) != std::string::npos) {
      tokens.push_back({std::string(1, c), line});
      ++at;
    } else {
      fail("unexpected character (code " + std::to_string(static_cast<unsigned char>(c)) + ")");
    }
  }
  tokens.push_back({"", line});
  return tokens;
}

}  // namespace fusion_slam
