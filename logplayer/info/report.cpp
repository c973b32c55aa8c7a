#include "logplayer/info/report.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <vector>

#include <nlohmann/json.hpp>

namespace fusion_slam {
namespace {

double seconds(std::int64_t us) { return static_cast<double>(us) * 1e-6; }

std::string fixed(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

std::string human_bytes(std::int64_t bytes) {
  if (bytes < 10'000) return std::to_string(bytes) + " bytes";
  if (bytes < 10'000'000) return fixed(static_cast<double>(bytes) / 1e3, 1) + " kB";
  return fixed(static_cast<double>(bytes) / 1e6, 1) + " MB";
}

// 2015-01-22 17:04:05.123456 UTC; just the number when that is no date.
std::string date(std::int64_t us) {
  const bool borrow = us % 1'000'000 < 0;
  const std::int64_t floor_s = us / 1'000'000 - (borrow ? 1 : 0);
  const std::int64_t fraction_us = us % 1'000'000 + (borrow ? 1'000'000 : 0);
  const auto time = static_cast<std::time_t>(floor_s);
  std::tm parts{};
  char text[64];
  if (gmtime_r(&time, &parts) == nullptr ||
      std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &parts) == 0) {
    return std::to_string(us) + " us";
  }
  char fraction[16];
  std::snprintf(fraction, sizeof fraction, ".%06d UTC", static_cast<int>(fraction_us));
  return std::string(text) + fraction;
}

double duration_s(const LogSummary& summary) {
  return seconds(summary.last_log_us) - seconds(summary.first_log_us);
}

std::string types_of(const ChannelSummary& channel) {
  std::string text;
  for (const auto& [fingerprint, count] : channel.messages_by_fingerprint) {
    text += (text.empty() ? "" : ", ") + type_name(fingerprint);
    if (channel.messages_by_fingerprint.size() > 1) text += " (" + std::to_string(count) + ")";
  }
  return text;
}

std::string utime(const std::optional<std::int64_t>& us) {
  return us ? fixed(seconds(*us), 6) : "-";
}

using Row = std::vector<std::string>;

std::string aligned(const std::vector<Row>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const Row& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string padding(widths[i] - row[i].size(), ' ');
      line += (i == 0 ? "" : "  ") + (i < 2 ? row[i] + padding : padding + row[i]);
    }
    text += line.erase(line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

}  // namespace

std::string text_report(const std::string& file, const LogSummary& summary) {
  std::string text = file + "\n";
  text += "size      " + human_bytes(summary.size_bytes) + ", " + std::to_string(summary.n_events) +
          " events, " + std::to_string(summary.channels.size()) + " channels\n";
  text += "start     " + date(summary.first_log_us) + "\n";
  text += "duration  " + fixed(duration_s(summary), 3) + " s\n\n";
  std::vector<Row> rows = {{"channel", "type", "count", "Hz", "min B", "mean B", "max B",
                            "largest gap s", "at s", "first utime s", "last utime s"}};
  for (const auto& [name, channel] : summary.channels) {
    rows.push_back({name, types_of(channel), std::to_string(channel.n_messages),
                    fixed(channel.rate_hz(), 2), std::to_string(channel.min_bytes),
                    std::to_string(channel.sum_bytes / channel.n_messages),
                    std::to_string(channel.max_bytes), fixed(seconds(channel.largest_gap_us), 3),
                    fixed(seconds(channel.largest_gap_begin_us) - seconds(summary.first_log_us), 3),
                    utime(channel.first_utime_us), utime(channel.last_utime_us)});
  }
  text += aligned(rows);
  if (summary.damages.empty()) return text;
  text += "\ndamaged in " + std::to_string(summary.damages.size()) +
          " places (`fusion-slam verify` lists all), the first:\n" +
          summary.damages.front().message + "\n";
  return text;
}

std::string json_report(const std::string& file, const LogSummary& summary) {
  nlohmann::json report = {{"file", file},
                           {"size_bytes", summary.size_bytes},
                           {"events", summary.n_events},
                           {"start_us", summary.first_log_us},
                           {"duration_s", duration_s(summary)},
                           {"channels", nlohmann::json::object()},
                           {"damages", nlohmann::json::array()}};
  for (const auto& [name, channel] : summary.channels) {
    nlohmann::json types = nlohmann::json::object();
    for (const auto& [fingerprint, count] : channel.messages_by_fingerprint)
      types[type_name(fingerprint)] = count;
    nlohmann::json entry = {{"types", types},
                            {"count", channel.n_messages},
                            {"rate_hz", channel.rate_hz()},
                            {"bytes",
                             {{"min", channel.min_bytes},
                              {"mean", static_cast<double>(channel.sum_bytes) /
                                           static_cast<double>(channel.n_messages)},
                              {"max", channel.max_bytes},
                              {"sum", channel.sum_bytes}}},
                            {"first_log_us", channel.first_log_us},
                            {"last_log_us", channel.last_log_us},
                            {"largest_gap_s", seconds(channel.largest_gap_us)},
                            {"largest_gap_begin_us", channel.largest_gap_begin_us},
                            {"first_utime_us", nullptr},
                            {"last_utime_us", nullptr}};
    if (channel.first_utime_us) entry["first_utime_us"] = *channel.first_utime_us;
    if (channel.last_utime_us) entry["last_utime_us"] = *channel.last_utime_us;
    report["channels"][name] = entry;
  }
  for (const LogDamage& damage : summary.damages) {
    report["damages"].push_back({{"offset_bytes", damage.offset_bytes},
                                 {"at_end", damage.at_end},
                                 {"message", damage.message}});
  }
  // A damaged log may hold channel names that are no UTF-8.
  return report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace fusion_slam
