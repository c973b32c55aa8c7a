#include "libs/datasets/text.hpp"

#include <charconv>
#include <cmath>
#include <memory>

#include <zlib.h>

namespace fusion_slam {
namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{1} << 31;
constexpr double kMaxSeconds = 4.0e12;  // the difference of two such times fits int64 microseconds

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v';
}

}  // namespace

void Skipped::add(std::int64_t place, const std::string& reason) {
  Entry& entry = reasons_[reason];
  if (entry.count++ == 0) entry.first_place = place;
}

void Skipped::add(const Skipped& other) {
  for (const auto& [reason, theirs] : other.reasons_) {
    Entry& ours = reasons_[reason];
    if (ours.count == 0) ours.first_place = theirs.first_place;
    ours.count += theirs.count;
  }
}

std::int64_t Skipped::total() const {
  std::int64_t total = 0;
  for (const auto& [reason, entry] : reasons_) total += entry.count;
  return total;
}

std::string read_text_file(const std::filesystem::path& path) {
  const std::string name = path.string();
  if (std::filesystem::is_directory(path))
    throw DatasetError(name + ": is a directory, a file is needed");
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(name.c_str(), "rb"), gzclose);
  if (!file) throw DatasetError(name + ": cannot be opened; check the path and its permissions");
  std::string text;
  std::vector<char> block(std::size_t{1} << 20);
  for (;;) {
    const int n = gzread(file.get(), block.data(), static_cast<unsigned>(block.size()));
    if (n > 0) text.append(block.data(), static_cast<std::size_t>(n));
    if (text.size() > kMaxFileBytes)
      throw DatasetError(name + ": is longer than 2 GiB uncompressed; split it");
    if (n < static_cast<int>(block.size())) break;
  }
  int error = Z_OK;
  gzerror(file.get(), &error);
  if (error != Z_OK)
    throw DatasetError(name + ": the compressed data are damaged or end early, after " +
                       std::to_string(text.size()) + " bytes of text; fetch the file again");
  if (text.empty()) throw DatasetError(name + ": is empty; fetch the file again");
  return text;
}

bool next_line(std::string_view* text, std::string_view* line) {
  if (text->empty()) return false;
  const std::size_t end = text->find('\n');
  *line = text->substr(0, end);
  text->remove_prefix(end == std::string_view::npos ? text->size() : end + 1);
  if (!line->empty() && line->back() == '\r') line->remove_suffix(1);
  return true;
}

std::string_view next_word(std::string_view* line) {
  std::size_t begin = 0;
  while (begin < line->size() && is_space((*line)[begin])) ++begin;
  std::size_t end = begin;
  while (end < line->size() && !is_space((*line)[end])) ++end;
  const std::string_view word = line->substr(begin, end - begin);
  line->remove_prefix(end);
  return word;
}

std::optional<double> parse_number(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

std::optional<std::int64_t> parse_integer(std::string_view word) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

std::optional<std::int64_t> parse_seconds_us(std::string_view word) {
  const std::size_t dot = word.find('.');
  const auto whole = parse_integer(word.substr(0, dot));
  const std::string_view digits =
      dot == std::string_view::npos ? std::string_view() : word.substr(dot + 1);
  if (whole && *whole >= 0 && word.front() != '-' && digits.size() <= 6 &&
      digits.find_first_not_of("0123456789") == std::string_view::npos &&
      static_cast<double>(*whole) < kMaxSeconds) {
    std::int64_t fraction = 0;
    for (std::size_t i = 0; i < 6; ++i)
      fraction = fraction * 10 + (i < digits.size() ? digits[i] - '0' : 0);
    return *whole * 1'000'000 + fraction;
  }
  const auto seconds = parse_number(word);
  if (!seconds || std::abs(*seconds) >= kMaxSeconds) return std::nullopt;
  return static_cast<std::int64_t>(std::llround(*seconds * 1e6));
}

}  // namespace fusion_slam
