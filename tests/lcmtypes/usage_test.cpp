// Types are for use: each of fusion_slam and bot_core is named by a source file, or held by a type
// that is; and each stands in the table of lcmtypes/README.md. procman_lcm is exempt from use: it
// is the lab's protocol, whole or not at all, and stays even while procman/ has no deputy of its
// own.
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "libs/schema/schema.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

// Without // comments: a type that is only talked about is not used.
std::string code(const fs::path& path) {
  std::ifstream file(path);
  std::string text;
  for (std::string line; std::getline(file, line);) text += line.substr(0, line.find("//")) + "\n";
  return text;
}

// All words of the C++ sources outside lcmtypes/ and tests/.
std::set<std::string> words_of_sources() {
  std::set<std::string> words;
  for (const char* const folder : {"libs", "services", "drivers", "logplayer", "viz", "procman"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(FS_SOURCE_DIR) / folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".cpp" && extension != ".hpp") continue;
      std::string word;
      for (const char c : code(entry.path())) {
        if (is_word(c)) {
          word += c;
        } else if (!word.empty()) {
          words.insert(word);
          word.clear();
        }
      }
    }
  }
  return words;
}

std::string package(const LcmType& type) { return type.name.substr(0, type.name.find('.')); }

void add_with_nested(const LcmType& type, std::set<std::string>* used) {
  if (!used->insert(type.name).second) return;
  for (const LcmMember& member : type.members) {
    if (member.nested != nullptr) add_with_nested(*member.nested, used);
  }
}

TEST(Usage, each_type_is_used) {
  const std::set<std::string> words = words_of_sources();
  std::set<std::string> used;
  for (const auto& [name, type] : builtin_schema().types()) {
    if (words.count(name.substr(name.find('.') + 1)) != 0) add_with_nested(type, &used);
  }
  for (const auto& [name, type] : builtin_schema().types()) {
    if (package(type) == "procman_lcm") continue;
    EXPECT_EQ(used.count(name), 1U) << name << " is used by nobody: delete its file or use it";
  }
}

TEST(Usage, fusion_slam_has_at_most_20_types) {
  int n = 0;
  for (const auto& [name, type] : builtin_schema().types())
    n += package(type) == "fusion_slam" ? 1 : 0;
  EXPECT_LE(n, 20);
}

TEST(Usage, each_type_is_in_the_readme) {
  const std::string readme = read(fs::path(FS_SOURCE_DIR) / "lcmtypes" / "README.md");
  for (const auto& [name, type] : builtin_schema().types()) {
    EXPECT_NE(readme.find("`" + name + "`"), std::string::npos)
        << name << " is not in lcmtypes/README.md";
  }
}

}  // namespace
}  // namespace fusion_slam
