#include "logplayer/verify/verifier.hpp"

#include <algorithm>
#include <optional>

#include "libs/eventlog/summary.hpp"
#include "libs/schema/big_endian.hpp"
#include "libs/schema/guard.hpp"
#include "libs/schema/walk.hpp"

namespace fusion_slam {
namespace {

// lcm-logger stamps a message when its first datagram arrives and writes it when the last is there:
// large messages are written behind small ones that came meanwhile.
constexpr std::uint64_t kLoggerJitter_us = 100'000;

// Several processes publish on STATUS and RESEND, each with numbers of its own: who sent this one?
// Empty: the channel's only publisher. Nothing: can't be told (COMMAND), so numbers say nothing.
std::optional<std::string> sender(const LcmType& type, const LogEvent& event) {
  if (type.name == "fusion_slam.command_t") return std::nullopt;
  std::string name;
  walk(type, event.data.data(), event.data.size(), [&](const LcmField& field) {
    if (field.path == "process" || field.path == "requester") name = string_value(field);
  });
  return name;
}

class Verifier {
 public:
  void add(const LogEvent& event) {
    ++report_.n_events;
    check_log_time(event);
    const LcmType* type = peek_type(event.data.data(), event.data.size());
    if (type == nullptr) {
      if (event.channel == "LCM_SELF_TEST") return;  // liblcm's own, once for each subscriber
      ++report_.foreign[{event.channel,
                         event.data.size() < 8 ? 0 : read_big_endian(event.data.data(), 8)}];
      return;
    }
    if (const auto reason = check(*type, event.data.data(), event.data.size())) {
      report_.findings.push_back(
          {event.offset_bytes, "undecodable", event.channel + ": cannot be decoded: " + *reason});
      return;
    }
    if (type->starts_with_utime) add_to_stream(*type, event);
  }

  void add(const LogDamage& damage) {
    report_.findings.push_back({damage.offset_bytes, "damage", damage.message});
  }

  VerifyReport finish() {
    for (auto& [key, stream] : streams_) {
      for (Finding& finding : stream.finish()) report_.findings.push_back(std::move(finding));
      report_.n_resent += stream.n_resent();
      report_.n_restarts += stream.n_restarts();
    }
    std::stable_sort(
        report_.findings.begin(), report_.findings.end(),
        [](const Finding& a, const Finding& b) { return a.offset_bytes < b.offset_bytes; });
    return std::move(report_);
  }

 private:
  void check_log_time(const LogEvent& event) {
    if (report_.n_events > 1 && event.timestamp_us < last_log_us_) {
      // Unsigned: time stamps of a damaged log may be any number.
      const std::uint64_t step_us =
          static_cast<std::uint64_t>(last_log_us_) - static_cast<std::uint64_t>(event.timestamp_us);
      if (step_us <= kLoggerJitter_us) {
        ++report_.n_jitter;
      } else {
        report_.findings.push_back(
            {event.offset_bytes, "log_time",
             event.channel + ": log time goes back" + backwards(last_log_us_, event.timestamp_us)});
      }
    }
    last_log_us_ = event.timestamp_us;
  }

  void add_to_stream(const LcmType& type, const LogEvent& event) {
    const auto who = type.continues_with_seq ? sender(type, event) : std::string();
    if (!who) return;
    const std::string name = event.channel + (who->empty() ? "" : " of " + *who);
    const bool check_time = type.name != "fusion_slam.tile_t";
    Stream& stream = streams_.try_emplace({name, type.fingerprint}, name, check_time).first->second;
    const std::int64_t utime_us = *peek_utime(event.data.data(), event.data.size());
    if (type.continues_with_seq) {
      stream.see(*peek_seq(event.data.data(), event.data.size()), utime_us, event.offset_bytes);
    } else {
      stream.see(utime_us, event.offset_bytes);
    }
  }

  VerifyReport report_;
  std::int64_t last_log_us_ = 0;
  std::map<std::pair<std::string, std::uint64_t>, Stream> streams_;
};

}  // namespace

VerifyReport verify(LogReader& reader) {
  Verifier verifier;
  LogEvent event;
  while (true) {
    while (reader.next(&event)) verifier.add(event);
    if (!reader.damage()) break;
    verifier.add(*reader.damage());
    if (!reader.resync()) break;
  }
  return verifier.finish();
}

std::string text_report(const std::string& file, const VerifyReport& report,
                        std::size_t max_lines) {
  static const std::map<std::string, std::string> kinds = {
      {"damage", "places that are no events"},
      {"hole", "holes in sequence numbers"},
      {"log_time", "steps back in log time"},
      {"time", "steps back in measurement time"},
      {"undecodable", "undecodable messages"}};
  std::string text;
  std::map<std::string, std::int64_t> counts;
  std::size_t n_lines = 0;
  for (const Finding& finding : report.findings) {
    ++counts[finding.kind];
    if (n_lines++ >= max_lines) continue;
    // The message of a damage names file and byte itself.
    text += finding.kind == "damage"
                ? finding.text
                : file + ": byte " + std::to_string(finding.offset_bytes) + ": " + finding.text;
    text += "\n";
  }
  if (n_lines > max_lines) {
    text += "... and " + std::to_string(n_lines - max_lines) + " more (--max-lines " +
            std::to_string(n_lines) + " shows all)\n";
  }
  for (const auto& [key, count] : report.foreign) {
    text += "note: " + key.first + ": " + std::to_string(count) +
            " messages of a type that this program doesn't have (" + type_name(key.second) +
            "); not checked\n";
  }
  if (report.n_jitter > 0)
    text += "note: " + std::to_string(report.n_jitter) +
            " events carry a log time up to 0.1 s before that of the event in front of them, as "
            "lcm-logger does it\n";
  if (report.n_resent > 0)
    text += "note: " + std::to_string(report.n_resent) +
            " messages stand in the log more than once (re-sent)\n";
  if (report.n_restarts > 0)
    text += "note: a publisher was started again " + std::to_string(report.n_restarts) + " times\n";
  text += file + ": " + std::to_string(report.n_events) + " events, ";
  if (report.findings.empty()) return text + "nothing wrong\n";
  std::string list;
  for (const auto& [kind, count] : counts)
    list += (list.empty() ? "" : ", ") + std::to_string(count) + " " + kinds.at(kind);
  return text + list + "\n";
}

}  // namespace fusion_slam
