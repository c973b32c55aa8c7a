// A YAML file of "key: value" lines that may only hold keys we know and values in range. Whatever
// is wrong throws ConfigError with the file, the line, the key and what to do.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <yaml-cpp/yaml.h>

namespace fusion_slam {

struct ConfigError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class YamlMap {
 public:
  // `valid_keys` are all keys that the file may have.
  static YamlMap from_file(const std::filesystem::path& path,
                           const std::vector<std::string>& valid_keys);
  static YamlMap from_text(const std::string& text, const std::string& file_name,
                           const std::vector<std::string>& valid_keys);

  bool has(const std::string& key) const { return values_.count(key) != 0; }
  // Each get throws when the value is not of this kind or out of range, or when the key is missing
  // and there is no default (require_...).
  double number(const std::string& key, double low, double high, double otherwise) const;
  double require_number(const std::string& key, double low, double high) const;
  bool flag(const std::string& key, bool otherwise) const;
  std::string text(const std::string& key, const std::string& otherwise) const;
  // One of `choices`, naming the nearest when it is none of them.
  std::string choice(const std::string& key, const std::vector<std::string>& choices,
                     const std::string& otherwise) const;
  // Exactly n numbers.
  std::vector<double> numbers(const std::string& key, std::size_t n, double low, double high,
                              const std::vector<double>& otherwise) const;

  [[noreturn]] void fail(const std::string& key, const std::string& what) const;

 private:
  std::string file_;
  std::map<std::string, YAML::Node> values_;
};

// The candidate with the smallest edit distance (insertions, deletions, replacements, swaps of
// neighbours); empty without candidates.
std::string nearest(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace fusion_slam
