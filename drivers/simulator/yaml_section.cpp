#include "drivers/simulator/yaml_section.hpp"

#include <fstream>
#include <sstream>
#include <utility>

namespace fusion_slam {

YamlSection::YamlSection(const YAML::Node& node, std::string file,
                         const std::vector<std::string>& keys)
    : node_(node), file_(std::move(file)) {
  if (!node_.IsMap()) fail(node_, "expected {key: value, ...}");
  for (const auto& item : node_) {
    const auto key = item.first.IsScalar() ? item.first.Scalar() : std::string("?");
    bool known = false;
    for (const std::string& k : keys) known = known || k == key;
    if (!known)
      fail(item.first,
           "unknown key '" + key + "'; the nearest valid key is '" + nearest(key, keys) + "'");
  }
}

std::string YamlSection::place(const YAML::Node& at) const {
  return file_ + ":" + std::to_string(at.Mark().line + 1);
}

void YamlSection::fail(const YAML::Node& at, const std::string& what) const {
  throw ConfigError(place(at) + ": " + what);
}

YAML::Node YamlSection::child(const std::string& key) const {
  if (!has(key)) fail(node_, "'" + key + "' is missing");
  return node_[key];
}

std::vector<YAML::Node> YamlSection::list(const std::string& key) const {
  std::vector<YAML::Node> items;
  if (!has(key)) return items;
  if (!node_[key].IsSequence()) fail(node_[key], "'" + key + "' must be a list");
  for (const auto& item : node_[key]) items.push_back(item);
  return items;
}

std::vector<double> YamlSection::numbers(const YAML::Node& at, const std::string& key,
                                         std::size_t least, std::size_t most) const {
  std::vector<double> values;
  if (at.IsSequence())
    for (const auto& item : at) {
      double value = NAN;
      if (!item.IsScalar() || !YAML::convert<double>::decode(item, value) ||
          !(std::fabs(value) < 1e4))
        fail(at, "'" + key + "' must hold numbers");
      values.push_back(value);
    }
  if (values.size() < least || values.size() > most)
    fail(at, "'" + key + "' must be a list of " + std::to_string(least) +
                 (most > least ? " or " + std::to_string(most) : "") + " numbers");
  return values;
}

double YamlSection::number(const std::string& key, double low, double high,
                           double otherwise) const {
  if (!has(key)) return otherwise;
  double value = NAN;
  if (!node_[key].IsScalar() || !YAML::convert<double>::decode(node_[key], value) ||
      !(value >= low && value <= high))
    fail(node_[key], "'" + key + "' must be a number from " + std::to_string(low) + " to " +
                         std::to_string(high));
  return value;
}

std::string YamlSection::word(const std::string& key,
                              const std::vector<std::string>& choices) const {
  const YAML::Node at = child(key);
  std::string value = at.IsScalar() ? at.Scalar() : "";
  for (const std::string& c : choices)
    if (c == value) return value;
  fail(at, "'" + key + "' is '" + value + "'; the nearest valid value is '" +
               nearest(value, choices) + "'");
}

std::string YamlSection::text(const std::string& key) const {
  if (!has(key)) return "";
  const YAML::Node at = child(key);
  if (!at.IsScalar()) fail(at, "'" + key + "' must be a text");
  return at.Scalar();
}

std::string text_of_file(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  if (!std::filesystem::is_regular_file(path) || !(text << file.rdbuf()))
    throw ConfigError(path.string() + ": cannot be read, or is empty; check the path");
  return text.str();
}

}  // namespace fusion_slam
