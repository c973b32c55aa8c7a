// A map within a YAML file whose every key must be known: world and route files. Whatever is wrong
// throws ConfigError with the file, the line, the key and what to do.
#pragma once

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "libs/config/yaml_map.hpp"

namespace fusion_slam {

class YamlSection {
 public:
  YamlSection(const YAML::Node& node, std::string file, const std::vector<std::string>& keys);

  [[noreturn]] void fail(const YAML::Node& at, const std::string& what) const;
  std::string place(const YAML::Node& at) const;  // "file:line"
  const YAML::Node& node() const { return node_; }
  const std::string& file() const { return file_; }
  bool has(const std::string& key) const { return node_[key].IsDefined(); }
  YAML::Node child(const std::string& key) const;  // must be there
  // Items of a list; none when the key is missing.
  std::vector<YAML::Node> list(const std::string& key) const;
  // `least` to `most` numbers below 10,000 in a list; `key` is for the message.
  std::vector<double> numbers(const YAML::Node& at, const std::string& key, std::size_t least,
                              std::size_t most) const;
  double number(const std::string& key, double low, double high, double otherwise) const;
  // One of `choices`; must be there.
  std::string word(const std::string& key, const std::vector<std::string>& choices) const;
  std::string text(const std::string& key) const;  // empty when missing

 private:
  YAML::Node node_;
  std::string file_;
};

// The whole of a text file. Throws ConfigError when it can't be read or is empty.
std::string text_of_file(const std::filesystem::path& path);

}  // namespace fusion_slam
