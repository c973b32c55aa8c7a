#include "viz/web/health_view.hpp"

#include <algorithm>

#include "viz/web/graph_view.hpp"

namespace fusion_slam {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kWindow_us = 3'000'000;  // rates are means of this
constexpr std::size_t kMostRecent = 1000;
constexpr std::size_t kMostProcesses = 200;  // names come from the network

const char* state_name(int state) {
  switch (state) {
    case status_t::STARTING:
      return "starting";
    case status_t::RUNNING:
      return "running";
    case status_t::FAILED:
      return "failed";
    case status_t::STOPPING:
      return "stopping";
    default:
      return "unknown";
  }
}

double seconds(std::int64_t us) { return 1e-6 * static_cast<double>(us); }

}  // namespace

void HealthView::on_status(const status_t& message, std::int64_t now_us) {
  if (processes_.size() >= kMostProcesses && processes_.count(message.process) == 0) return;
  Process& process = processes_[message.process];
  std::int64_t processed = 0;
  for (const channel_stats_t& channel : message.channels) processed += channel.processed;
  const double dt_s = seconds(message.utime - process.status.utime);
  const bool follows = process.status.pid == message.pid && process.heard_us != 0;
  if (follows && dt_s < 0.5) return;  // a lockstep replay says STATUS at each step
  if (follows) {
    process.rate_hz = static_cast<double>(processed - process.processed) / dt_s;
    process.cpu_percent = 100.0 * (message.cpu_s - process.status.cpu_s) / dt_s;
  }
  process.status = message;
  process.heard_us = now_us;
  process.processed = processed;
  put(message.process, process, now_us);
}

void HealthView::on_input(const std::string& channel, std::int64_t utime_us, std::size_t size_bytes,
                          std::int64_t now_us) {
  Input& input = inputs_[channel];
  const bool first = input.heard_us == 0;
  input.utime_us = std::max(input.utime_us, utime_us);
  input.heard_us = now_us;
  input.recent.emplace_back(utime_us, size_bytes);
  while (input.recent.size() > kMostRecent || input.recent.front().first < utime_us - kWindow_us)
    input.recent.pop_front();
  if (first) put(channel, input, now_us);
}

std::int64_t HealthView::newest_input_us() const {
  std::int64_t newest = 0;
  for (const auto& [channel, input] : inputs_) newest = std::max(newest, input.utime_us);
  return newest;
}

void HealthView::tick(std::int64_t now_us) {
  for (const auto& [name, process] : processes_) put(name, process, now_us);
  for (const auto& [channel, input] : inputs_) put(channel, input, now_us);
}

void HealthView::put(const std::string& name, const Process& process, std::int64_t now_us) {
  const status_t& status = process.status;
  std::int64_t dropped = 0;
  std::int64_t lost = 0;
  std::int64_t late = 0;
  std::int64_t rejected = 0;
  Json behind = Json::object();
  for (const channel_stats_t& channel : status.channels) {
    dropped += channel.dropped;
    lost += channel.lost;
    late += channel.late;
    rejected += channel.rejected;
    const auto input = inputs_.find(channel.channel);
    if (channel.subscribed && channel.last_utime > 0 && input != inputs_.end())
      behind[channel.channel] = std::max(0.0, seconds(input->second.utime_us - channel.last_utime));
  }
  const bool silent = now_us - process.heard_us > kSilent_us;
  store_.put(Topic::kHealth, name,
             to_text({{"process", name},
                      {"host", status.host},
                      {"pid", status.pid},
                      {"state", silent ? "silent" : state_name(status.state)},
                      {"text", status.state_text},
                      {"silent_s", silent ? seconds(now_us - process.heard_us) : 0.0},
                      {"rate_hz", process.rate_hz},
                      {"latency_ms", status.latency_ms_median},
                      {"latency_p95_ms", status.latency_ms_p95},
                      {"latency_p99_ms", status.latency_ms_p99},
                      {"queue", status.queue},
                      {"cpu_percent", process.cpu_percent},
                      {"memory_bytes", status.peak_rss_bytes},
                      {"dropped", dropped},
                      {"lost", lost},
                      {"late", late},
                      {"rejected", rejected},
                      {"behind_s", behind},
                      {"last_error", status.last_error}}));
}

// Late by: how long nothing has come, or how far its measurements are behind those of the other
// sensors.
void HealthView::put(const std::string& channel, const Input& input, std::int64_t now_us) {
  const std::int64_t span_us = input.recent.back().first - input.recent.front().first;
  const auto n = static_cast<double>(input.recent.size());
  const double rate_hz = span_us > 0 ? (n - 1.0) / seconds(span_us) : 0.0;
  double n_bytes = 0.0;
  for (const auto& [utime_us, size_bytes] : input.recent)
    n_bytes += static_cast<double>(size_bytes);
  const std::int64_t silence_us = std::max<std::int64_t>(0, now_us - input.heard_us);
  const std::int64_t behind_us = std::max<std::int64_t>(0, newest_input_us() - input.utime_us);
  const std::int64_t late_us = std::max(silence_us, behind_us);
  const double period_us = rate_hz > 0.0 ? 1e6 / rate_hz : 1e6;
  const bool is_late =
      late_us > kLateAtLeast_us && static_cast<double>(late_us) > kLatePeriods * period_us;
  store_.put(Topic::kInput, channel,
             to_text({{"channel", channel},
                      {"rate_hz", rate_hz},
                      {"bytes_s", rate_hz > 0.0 ? n_bytes / n * rate_hz : 0.0},
                      {"utime", input.utime_us},
                      {"late", is_late},
                      {"late_s", is_late ? seconds(late_us) : 0.0}}));
}

void HealthView::clear() {
  processes_.clear();
  inputs_.clear();
  store_.remove_all(Topic::kHealth);
  store_.remove_all(Topic::kInput);
}

}  // namespace fusion_slam
