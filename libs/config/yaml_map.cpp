#include "libs/config/yaml_map.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

namespace fusion_slam {
namespace {

std::string place(const std::string& file, const YAML::Mark& mark) {
  return file + ":" + std::to_string(mark.line + 1) + ": ";
}

std::string shown(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      const std::size_t replaced = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({replaced, d[i - 1][j] + 1, d[i][j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

[[noreturn]] void refuse_unknown(const std::string& where, const std::string& key,
                                 const std::vector<std::string>& valid_keys) {
  throw ConfigError(where + "unknown key '" + key + "'; the nearest valid key is '" +
                    nearest(key, valid_keys) + "'");
}

[[noreturn]] void refuse_repeated(const std::string& where, const std::string& key) {
  throw ConfigError(where + "key '" + key + "' is given twice; keep one");
}

}  // namespace

std::string nearest(const std::string& word, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance) best = candidate;
    best_distance = std::min(distance, best_distance);
  }
  return best;
}

YamlMap YamlMap::from_file(const std::filesystem::path& path,
                           const std::vector<std::string>& valid_keys) {
  std::ifstream file(path);
  std::ostringstream text;
  if (!std::filesystem::is_regular_file(path) || !(text << file.rdbuf()))
    throw ConfigError(path.string() + ": cannot be read, or is empty; check the path");
  return from_text(text.str(), path.string(), valid_keys);
}

YamlMap YamlMap::from_text(const std::string& text, const std::string& file_name,
                           const std::vector<std::string>& valid_keys) {
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw ConfigError(place(file_name, error.mark) + "not valid YAML: " + error.msg);
  }
  if (!root.IsMap()) throw ConfigError(file_name + ":1: is not a list of \"key: value\" lines");
  YamlMap map;
  map.file_ = file_name;
  for (const auto& item : root) {
    const std::string where = place(file_name, item.first.Mark());
    if (!item.first.IsScalar()) throw ConfigError(where + "a key must be one word");
    const std::string key = item.first.Scalar();
    if (std::find(valid_keys.begin(), valid_keys.end(), key) == valid_keys.end())
      refuse_unknown(where, key, valid_keys);
    if (!map.values_.emplace(key, item.second).second) refuse_repeated(where, key);
  }
  return map;
}

void YamlMap::fail(const std::string& key, const std::string& what) const {
  const auto value = values_.find(key);
  const std::string where =
      value == values_.end() ? file_ + ":1: " : place(file_, value->second.Mark());
  throw ConfigError(where + "'" + key + "' " + what);
}

double YamlMap::require_number(const std::string& key, double low, double high) const {
  if (!has(key)) fail(key, "is missing; give a number");
  double value = 0.0;
  const YAML::Node& node = values_.at(key);
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value))
    fail(key, "must be a number");
  if (value < low || value > high)
    fail(key,
         "is " + shown(value) + ", which is not between " + shown(low) + " and " + shown(high));
  return value;
}

double YamlMap::number(const std::string& key, double low, double high, double otherwise) const {
  return has(key) ? require_number(key, low, high) : otherwise;
}

bool YamlMap::flag(const std::string& key, bool otherwise) const {
  if (!has(key)) return otherwise;
  bool value = false;
  if (!values_.at(key).IsScalar() || !YAML::convert<bool>::decode(values_.at(key), value))
    fail(key, "must be true or false");
  return value;
}

std::string YamlMap::text(const std::string& key, const std::string& otherwise) const {
  if (!has(key)) return otherwise;
  if (!values_.at(key).IsScalar() || values_.at(key).Scalar().empty()) fail(key, "must be a word");
  return values_.at(key).Scalar();
}

std::string YamlMap::choice(const std::string& key, const std::vector<std::string>& choices,
                            const std::string& otherwise) const {
  std::string value = text(key, otherwise);
  if (!has(key) || std::find(choices.begin(), choices.end(), value) != choices.end()) return value;
  std::string all;
  for (const std::string& c : choices) all += (all.empty() ? "" : ", ") + c;
  fail(key, "is '" + value + "'; the nearest valid value is '" + nearest(value, choices) +
                "' (valid: " + all + ")");
}

std::vector<double> YamlMap::numbers(const std::string& key, std::size_t n, double low, double high,
                                     const std::vector<double>& otherwise) const {
  if (!has(key)) return otherwise;
  const YAML::Node& node = values_.at(key);
  if (!node.IsSequence() || node.size() != n)
    fail(key, "must be a list of " + std::to_string(n) + " numbers");
  std::vector<double> values;
  for (const auto& item : node) {
    double value = 0.0;
    if (!item.IsScalar() || !YAML::convert<double>::decode(item, value) || !std::isfinite(value))
      fail(key, "must be a list of " + std::to_string(n) + " numbers");
    if (value < low || value > high)
      fail(key, "holds " + shown(value) + ", which is not between " + shown(low) + " and " +
                    shown(high));
    values.push_back(value);
  }
  return values;
}

}  // namespace fusion_slam
