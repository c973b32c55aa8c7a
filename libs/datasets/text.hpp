// Reading text recordings: whole files (plain or .gz), lines, numbers, and the account of what was
// skipped.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace fusion_slam {

// A file that cannot be used at all. what() names the file, the place and what to do.
struct DatasetError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// What a reader left out: how often for each reason, and the place (line, frame or event) where it
// happened first.
class Skipped {
 public:
  void add(std::int64_t place, const std::string& reason);
  void add(const Skipped& other);
  std::int64_t total() const;
  struct Entry {
    std::int64_t count = 0;
    std::int64_t first_place = 0;
  };
  const std::map<std::string, Entry>& reasons() const { return reasons_; }

 private:
  std::map<std::string, Entry> reasons_;
};

// The bytes of a file, uncompressed when it is a gzip file. Throws DatasetError (missing, a
// directory, empty, a compressed file that ends early, over 2 GiB).
std::string read_text_file(const std::filesystem::path& path);

// Takes the next line (without its end, also "\r\n") off `text`; false at the end.
bool next_line(std::string_view* text, std::string_view* line);
// Takes the next word off `line`; empty at the end.
std::string_view next_word(std::string_view* line);

std::optional<double> parse_number(std::string_view word);  // finite only
std::optional<std::int64_t> parse_integer(std::string_view word);
// Decimal seconds ("1305031453.359684") to microseconds without a detour through floating point
// where there is no exponent; none when it does not fit.
std::optional<std::int64_t> parse_seconds_us(std::string_view word);

}  // namespace fusion_slam
