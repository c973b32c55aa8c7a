// The handling side of the Bus: one message after the other, or one step of a lockstep replay after
// the other.
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <thread>
#include <utility>

#include <sys/resource.h>
#include <unistd.h>

#include "libs/bus/bus_internal.hpp"
#include "libs/clock/clock.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kErrorsPrinted = 20;
constexpr std::int64_t kBurst_us = 2'000;
constexpr int kBurstMessages = 8;
constexpr std::size_t kBurstBytes = 400'000;

std::map<std::string, std::int64_t> counts_of(const step_t& step) {
  std::map<std::string, std::int64_t> counts;
  for (std::size_t i = 0; i < step.channels.size(); ++i) counts[step.channels[i]] = step.counts[i];
  return counts;
}

std::string host_name() {
  char name[256] = {};
  gethostname(name, sizeof(name) - 1);
  return name;
}

}  // namespace

Bus::Impl::Impl(BusOptions options_in, std::shared_ptr<Transport> transport_in)
    : options(std::move(options_in)),
      transport(std::move(transport_in)),
      inbox(options.mode, options.keep_all_bound, options.merge_wait_us) {
  started_us = wall_us();
  const char* key_file = std::getenv("FUSION_SLAM_KEY_FILE");
  if (options.key_file.empty() && key_file != nullptr) options.key_file = key_file;
  if (options.mode == Mode::kLive && !options.key_file.empty())
    key = load_signing_key(options.key_file);
  // A process that was killed and started again must not send tiles that look older than those its
  // listeners have: this grows faster than any tile's revision, and a double still holds it.
  if (options.mode == Mode::kLive) first_revision = wall_us() / 1'000'000 * 1'000'000;
}

void Bus::Impl::start() {
  const Schema& schema = builtin_schema();
  listen("RESEND", schema.find("fusion_slam.resend_t"),
         bus_detail::decoder<resend_t>([this](const resend_t& m) { on_resend(m); }));
  // In lockstep STEP says what to expect; otherwise the peers' own counts do.
  if (options.mode == Mode::kLockstep)
    listen("STEP", schema.find("fusion_slam.step_t"),
           bus_detail::decoder<step_t>([this](const step_t& m) { on_step(m); }));
  else
    listen("STATUS", schema.find("fusion_slam.status_t"),
           bus_detail::decoder<status_t>([this](const status_t& m) { on_peer_status(m); }));
  tokens.push_back(transport->on_idle([this] { idle(); }));
}

void Bus::Impl::handle_item(const InboxItem& item) {
  Handler* handler = nullptr;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    handler = &handlers[item.channel];
  }
  write_to_journal(item);
  bool rejected = false;
  try {
    handler->decode(item.bytes.data(), item.bytes.size());
  } catch (const bus_detail::Undecodable& error) {
    rejected = true;
    report(std::string("message rejected: ") + error.what());
  }
  const std::lock_guard<std::mutex> lock(mutex);
  if (rejected) ++inbox.channels()[item.channel].counters.rejected;
  inbox.processed(item);
  latency.add(static_cast<double>(steady_us() - item.arrival_us));
  ++activity;
}

// Plain LCM listeners (lcm-logger, lcm-spy) queue 30 messages and drop the newest; their sockets
// hold a few hundred KB. Long bursts are therefore spread: ours would repair the loss, theirs
// can't.
void Bus::Impl::pace() {
  {
    const std::lock_guard<std::mutex> lock(out_mutex);
    const bool full = burst_messages >= kBurstMessages || burst_bytes >= kBurstBytes;
    if (!full || steady_us() - burst_begin_us > kBurst_us) return;
  }
  // Not under the lock: the reader's thread must not wait for it.
  std::this_thread::sleep_for(std::chrono::microseconds(kBurst_us));
}

void Bus::Impl::send(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  const std::int64_t now = steady_us();
  if (now - burst_begin_us > kBurst_us) {
    burst_begin_us = now;
    burst_messages = 0;
    burst_bytes = 0;
  }
  ++burst_messages;
  burst_bytes += bytes.size();
  transport->publish(channel, bytes);
  ++activity;
}

bool Bus::Impl::handle_one(int timeout_ms) {
  const std::int64_t deadline_us = steady_us() + timeout_ms * 1000LL;
  std::optional<InboxItem> item;
  {
    std::unique_lock<std::mutex> lock(mutex);
    while (!(item = inbox.pop(steady_us())) && !stopping) {
      const std::int64_t left_us = deadline_us - steady_us();
      if (left_us <= 0) return false;
      // Something may wait for its merge time only: look again soon.
      const std::int64_t wait_us =
          inbox.waiting() > 0 ? std::min<std::int64_t>(left_us, 1000) : left_us;
      changed.wait_for(lock, std::chrono::microseconds(wait_us));
    }
    changed.notify_all();
  }
  if (!item) return false;
  handle_item(*item);
  return true;
}

bool Bus::Impl::handle_step(int timeout_ms) {
  std::vector<InboxItem> items;
  std::int64_t step = 0;
  {
    std::unique_lock<std::mutex> lock(mutex);
    const auto wait = std::chrono::milliseconds(timeout_ms);
    if (steps.empty() &&
        !changed.wait_for(lock, wait, [this] { return !steps.empty() || stopping; }))
      return false;
    if (stopping || steps.empty()) return false;
    const auto counts = counts_of(steps.front());
    step = steps.front().step;
    if (inbox.has_work(counts)) {
      if (!changed.wait_for(lock, wait, [&] { return inbox.complete(counts) || stopping; }))
        return false;
      if (stopping) return false;
      items = inbox.take(counts);
    }
    steps.pop_front();
  }
  for (const InboxItem& item : items) handle_item(item);
  {
    const std::lock_guard<std::mutex> lock(mutex);
    step_done = step;
  }
  if (items.empty()) return false;  // nobody waits for us
  send_status();
  return true;
}

void Bus::Impl::call_timers() {
  if (options.mode == Mode::kLockstep) return;
  const std::int64_t now = steady_us();
  for (Timer& timer : timers) {
    if (now - timer.last_us < timer.period_us) continue;
    timer.last_us = now;
    timer.callback();
  }
}

void Bus::Impl::report(const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex);
  last_error = text;
  if (++error_count <= kErrorsPrinted) std::cerr << options.process << ": " << text << std::endl;
  if (error_count == kErrorsPrinted)
    std::cerr << options.process << ": further errors are only counted, see STATUS" << std::endl;
}

status_t Bus::Impl::status() const {
  status_t s{};
  s.utime = wall_us();
  s.process = options.process;
  s.host = host_name();
  s.pid = getpid();
  s.state = stopping ? status_t::STOPPING : (running ? status_t::RUNNING : status_t::STARTING);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  s.cpu_s = static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
            1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  s.peak_rss_bytes = usage.ru_maxrss * 1024L;
  std::map<std::string, channel_stats_t> channels;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    for (const auto& [name, rejected] : listened_rejected) channels[name].rejected = rejected;
    s.state_text = state_text;
    s.last_error = last_error;
    s.step = step_done;
    s.queue = static_cast<std::int32_t>(inbox.waiting());
    s.latency_ms_median = latency.percentile_ms(0.5);
    s.latency_ms_p95 = latency.percentile_ms(0.95);
    s.latency_ms_p99 = latency.percentile_ms(0.99);
    for (const auto& channel : inbox.channels()) {
      channel_stats_t& stats = channels[channel.name];
      stats.subscribed = 1;
      stats.received = channel.counters.received;
      stats.processed = channel.counters.processed;
      stats.dropped = channel.counters.dropped;
      stats.lost = channel.counters.lost;
      stats.late = channel.counters.late;
      stats.duplicated = channel.counters.duplicated;
      stats.rejected += channel.counters.rejected;
      stats.bytes = channel.counters.bytes;
      stats.last_utime = channel.counters.last_utime_us;
    }
  }
  {
    const std::lock_guard<std::mutex> lock(out_mutex);
    for (const auto& [name, count] : outbox.counts()) {
      channels[name].published = count;
      channels[name].bytes += outbox.bytes(name);
    }
  }
  for (auto& [name, stats] : channels) {
    stats.channel = name;
    s.channels.push_back(stats);
  }
  s.n_channels = static_cast<std::int32_t>(s.channels.size());
  return s;
}

void Bus::Impl::send_status() {
  const std::lock_guard<std::mutex> one_at_a_time(status_mutex);  // so that counts never go back
  last_status_us = steady_us();
  told_activity = activity.load();
  status_t s = status();
  const std::lock_guard<std::mutex> lock(out_mutex);
  // Listeners take these counts for what was sent before this STATUS: no more, no less.
  for (auto& stats : s.channels) stats.published = outbox.next_seq(stats.channel) - 1;
  s.seq = outbox.next_seq("STATUS");
  const auto bytes = bus_detail::encode(s);
  outbox.sent_once("STATUS", bytes.size());
  transport->publish("STATUS", bytes);
}

}  // namespace fusion_slam
