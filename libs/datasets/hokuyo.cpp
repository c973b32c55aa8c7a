#include "libs/datasets/hokuyo.hpp"

#include <cmath>

namespace fusion_slam {
namespace {

constexpr std::size_t kFirstRange = 24;
// The URG-04LX divides the circle into 1024 steps, counter-clockwise; step 384 looks forward
// and 44..725 are measured.
constexpr std::size_t kRanges = 682;
constexpr double kStepRad = 2.0 * M_PI / 1024.0;
constexpr double kFirstStep = 44.0 - 384.0;
// Below 20 mm the value is an error code of the sensor.
constexpr std::int64_t kSmallestRangeMm = 20;
constexpr std::int64_t kLatestUs = 4'000'000'000'000'000'000;  // differences of times must fit

std::optional<HokuyoRecord> parse_line(std::string_view line, std::string* why) {
  HokuyoRecord record;
  record.scan.rad0 = kFirstStep * kStepRad;
  record.scan.radstep = kStepRad;
  for (std::size_t field = 0; field < kFirstRange + kRanges; ++field) {
    const std::string_view word = next_word(&line);
    if (word.empty()) return *why = "fewer than 706 numbers", std::nullopt;
    const bool needed = field == 0 || field == 2 || field == 3 || field >= kFirstRange;
    if (!needed) continue;
    const auto value = parse_integer(word);
    if (!value) return *why = "not an integer", std::nullopt;
    if (field == 0 && (*value < 0 || *value > kLatestUs))
      return *why = "time is not plausible", std::nullopt;
    if (field == 0)
      record.scan.utime_us = *value;
    else if (field == 2)
      record.left_ticks = *value;
    else if (field == 3)
      record.right_ticks = *value;
    else
      record.scan.ranges_m.push_back(
          *value < kSmallestRangeMm ? 0.0F : static_cast<float>(*value) * 0.001F);
  }
  return record;
}

}  // namespace

HokuyoLog parse_mines_hokuyo(std::string_view text) {
  HokuyoLog log;
  std::string_view line;
  while (next_line(&text, &line)) {
    ++log.lines;
    if (line.empty()) continue;
    std::string why;
    auto record = parse_line(line, &why);
    if (record && !log.records.empty() &&
        record->scan.utime_us <= log.records.back().scan.utime_us) {
      why = "time does not increase";
      record.reset();
    }
    if (!record) {
      log.skipped.add(log.lines, why);
      continue;
    }
    record->line = log.lines;
    log.records.push_back(std::move(*record));
  }
  return log;
}

HokuyoLog read_mines_hokuyo(const std::filesystem::path& path) {
  HokuyoLog log = parse_mines_hokuyo(read_text_file(path));
  if (!log.records.empty()) return log;
  std::string message =
      path.string() + ": no usable line of 706 integers in " + std::to_string(log.lines) + " lines";
  for (const auto& [reason, entry] : log.skipped.reasons())
    message += "; line " + std::to_string(entry.first_place) + ": " + reason;
  throw DatasetError(message + "; is this a Mines Hokuyo recording?");
}

}  // namespace fusion_slam
