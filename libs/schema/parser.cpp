#include "libs/schema/parser.hpp"

#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <map>
#include <stdexcept>

#include "libs/schema/lexer.hpp"

namespace fusion_slam {
namespace {

const std::map<std::string, LcmPrimitive>& primitives() {
  static const std::map<std::string, LcmPrimitive> table = {
      {"boolean", LcmPrimitive::kBoolean}, {"byte", LcmPrimitive::kByte},
      {"int8_t", LcmPrimitive::kInt8},     {"int16_t", LcmPrimitive::kInt16},
      {"int32_t", LcmPrimitive::kInt32},   {"int64_t", LcmPrimitive::kInt64},
      {"float", LcmPrimitive::kFloat},     {"double", LcmPrimitive::kDouble},
      {"string", LcmPrimitive::kString}};
  return table;
}

bool is_integer(LcmPrimitive p) {
  return p == LcmPrimitive::kInt8 || p == LcmPrimitive::kInt16 || p == LcmPrimitive::kInt32 ||
         p == LcmPrimitive::kInt64;
}

bool is_name(const std::string& text, bool dots) {
  if (text.empty() || std::isdigit(static_cast<unsigned char>(text[0])) != 0) return false;
  bool after_dot = true;
  for (const char c : text) {
    if (c == '.' ? (!dots || after_dot)
                 : (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_'))
      return false;
    after_dot = c == '.';
  }
  return !after_dot;
}

class Parser {
 public:
  Parser(const std::string& file, const std::string& text)
      : file_(file), tokens_(lcm_tokens(file, text)) {}

  std::vector<LcmType> run() {
    std::vector<LcmType> types;
    while (!peek().empty()) {
      if (accept("package")) {
        package_ = name("the package's name", true);
        expect(";");
      } else if (accept("struct")) {
        types.push_back(parse_struct());
      } else {
        fail("expected `package` or `struct` but found `" + peek() + "`");
      }
    }
    return types;
  }

 private:
  LcmType parse_struct() {
    LcmType type;
    type.name = qualified(name("the struct's name", false));
    expect("{");
    while (!accept("}")) {
      if (accept("const")) {
        parse_constants(&type);
      } else {
        parse_members(&type);
      }
    }
    return type;
  }

  // const int32_t A = 1, B = 2;
  void parse_constants(LcmType* type) {
    const std::string type_name = name("a constant's type", false);
    do {
      LcmConstant constant{name("a constant's name", false), type_name, ""};
      expect("=");
      constant.value = next();
      type->constants.push_back(constant);
    } while (accept(","));
    expect(";");
  }

  // float a[3], b[n][2];
  void parse_members(LcmType* type) {
    const std::string type_name = name("a member's type", true);
    const auto primitive = primitives().find(type_name);
    do {
      LcmMember member;
      member.name = name("a member's name", false);
      for (const LcmMember& other : type->members) {
        if (other.name == member.name) fail("member `" + member.name + "` is declared twice");
      }
      const bool is_primitive = primitive != primitives().end();
      member.type_name = is_primitive ? type_name : qualified(type_name);
      member.primitive = is_primitive ? primitive->second : LcmPrimitive::kStruct;
      while (accept("[")) {
        member.dimensions.push_back(parse_dimension(*type));
        expect("]");
      }
      type->members.push_back(member);
    } while (accept(","));
    expect(";");
  }

  LcmDimension parse_dimension(const LcmType& type) {
    LcmDimension dimension;
    dimension.text = next();
    if (!dimension.text.empty() &&
        std::isdigit(static_cast<unsigned char>(dimension.text[0])) != 0) {
      char* end = nullptr;
      errno = 0;
      dimension.fixed_count = std::strtoll(dimension.text.c_str(), &end, 0);
      if (*end != '\0' || errno != 0 || dimension.fixed_count <= 0 ||
          dimension.fixed_count > INT32_MAX) {
        fail("array size `" + dimension.text + "` is not a positive 32 bit number");
      }
      return dimension;
    }
    for (std::size_t i = 0; i < type.members.size(); ++i) {
      const LcmMember& member = type.members[i];
      if (member.name != dimension.text) continue;
      if (!is_integer(member.primitive) || !member.dimensions.empty()) {
        fail("array size `" + dimension.text + "` has to be an integer member that is no array");
      }
      dimension.length_member = static_cast<int>(i);
      return dimension;
    }
    fail("array size `" + dimension.text +
         "` has to be a number or a member declared before the array");
  }

  std::string qualified(const std::string& text) const {
    return package_.empty() || text.find('.') != std::string::npos ? text : package_ + "." + text;
  }

  const std::string& peek() const { return tokens_[at_].text; }

  std::string next() {
    std::string text = peek();
    if (text.empty()) fail("the file ends in the middle of a declaration");
    ++at_;
    return text;
  }

  bool accept(const std::string& text) {
    if (peek() != text) return false;
    ++at_;
    return true;
  }

  void expect(const std::string& text) {
    if (!accept(text))
      fail("expected `" + text + "` but found " +
           (peek().empty() ? "the end" : "`" + peek() + "`"));
  }

  std::string name(const std::string& what, bool dots) {
    if (!is_name(peek(), dots)) fail("expected " + what + " but found `" + peek() + "`");
    return next();
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(file_ + ":" + std::to_string(tokens_[at_].line) + ": " + what);
  }

  std::string file_;
  std::vector<LcmToken> tokens_;
  std::size_t at_ = 0;
  std::string package_;
};

}  // namespace

std::vector<LcmType> parse_lcm(const std::string& file, const std::string& text) {
  return Parser(file, text).run();
}

}  // namespace fusion_slam
