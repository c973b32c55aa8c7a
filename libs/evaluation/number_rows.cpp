#include "libs/evaluation/number_rows.hpp"

#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

namespace fusion_slam {
namespace {

constexpr std::string_view kBlank = " \t\r\v\f";

std::vector<std::string_view> split_fields(std::string_view line) {
  std::vector<std::string_view> fields;
  std::size_t begin = line.find_first_not_of(kBlank);
  while (begin != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(kBlank, begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlank, end);
  }
  return fields;
}

// What a terminal can show of a field that may be binary garbage.
std::string printable(std::string_view field) {
  std::string shown;
  for (const char c : field.substr(0, 24)) {
    shown += std::isprint(static_cast<unsigned char>(c)) != 0 ? c : '?';
  }
  return field.size() > 24 ? shown + "..." : shown;
}

bool parse_number(std::string_view field, double& value) {
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  const char* end = field.data() + field.size();
  const auto [rest, error] = std::from_chars(field.data(), end, value);
  return error == std::errc() && rest == end && std::isfinite(value);
}

}  // namespace

FileError::FileError(const std::string& file, std::size_t line, const std::string& reason)
    : std::runtime_error(file + ":" + std::to_string(line) + ": " + reason) {}

FileError::FileError(const std::string& file, const std::string& reason)
    : std::runtime_error(file + ": " + reason) {}

std::vector<NumberRow> read_number_rows(std::istream& in, const std::string& name,
                                        const std::string& columns) {
  std::vector<NumberRow> rows;
  std::string text;
  for (std::size_t line = 1; std::getline(in, text); ++line) {
    const std::vector<std::string_view> fields = split_fields(text);
    if (fields.empty() || fields[0][0] == '#') continue;
    NumberRow row;
    row.line = line;
    if (fields.size() != row.values.size()) {
      throw FileError(name, line,
                      "expected 8 numbers separated by blanks (" + columns + "), found " +
                          std::to_string(fields.size()) +
                          (fields.size() == 1 ? " field: '" : " fields: '") + printable(fields[0]) +
                          "' first");
    }
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (!parse_number(fields[i], row.values[i])) {
        throw FileError(name, line,
                        "field " + std::to_string(i + 1) + " of (" + columns + ") is '" +
                            printable(fields[i]) + "', which is not a finite number");
      }
    }
    rows.push_back(row);
  }
  if (in.bad()) throw FileError(name, "reading failed half-way; is the disk or network well?");
  if (rows.empty()) throw FileError(name, "no line of numbers in it (" + columns + ")");
  return rows;
}

std::vector<NumberRow> read_number_rows(const std::filesystem::path& file,
                                        const std::string& columns) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    throw FileError(file.string(), "no such file; check the path");
  }
  if (std::filesystem::is_directory(file, ignored)) {
    throw FileError(file.string(), "is a directory; name the file in it");
  }
  std::ifstream in(file);
  if (!in) throw FileError(file.string(), "can't be opened; check its permissions");
  return read_number_rows(in, file.string(), columns);
}

}  // namespace fusion_slam
