#include "logplayer/replay/conductor.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "fusion_slam/command_t.hpp"
#include "libs/schema/guard.hpp"

namespace fusion_slam {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kPollPeriod = std::chrono::milliseconds(50);
constexpr auto kStepRepeat = std::chrono::milliseconds(200);  // a lost STEP is sent again
constexpr std::size_t kRepeatMemory = 256;  // as the receivers' (libs/bus/inbox.cpp)
constexpr int kMostWaiting = 32;
constexpr std::size_t kOneDatagram = 65'000;  // LCM cuts larger messages into several

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

// Channels that keep the network running and wait for nobody.
bool is_control_channel(const std::string& channel) {
  return channel == "STATUS" || channel == "STEP" || channel == "RESEND" ||
         ends_with(channel, "_INDEX");
}

// A log may begin anywhere: its messages get this run's own numbers.
std::vector<std::uint8_t> renumbered(const LogEvent& event, std::int64_t seq) {
  std::vector<std::uint8_t> bytes = event.data;
  if (!peek_seq(bytes.data(), bytes.size())) return bytes;
  for (std::size_t i = 0; i < 8; ++i)
    bytes[16 + i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(seq) >> (56 - 8 * i));
  return bytes;
}

// Sensors' channels and their types.
const std::map<std::string, const LcmType*>& sensors() {
  static const std::map<std::string, const LcmType*> kSensors = [] {
    const Schema& schema = builtin_schema();
    return std::map<std::string, const LcmType*>{
        {"CAMERA", schema.find("bot_core.images_t")},
        {"CAMERA_MODEL", schema.find("fusion_slam.camera_model_t")},
        {"LIDAR", schema.find("bot_core.planar_lidar_t")},
        {"ROBOT_MODEL", schema.find("fusion_slam.robot_model_t")},
        {"ODOMETRY", schema.find("bot_core.pose_t")},
        {"GROUND_TRUTH", schema.find("bot_core.pose_t")}};
  }();
  return kSensors;
}

std::size_t hash_of(const LogEvent& event) {
  return std::hash<std::string_view>()(
      {reinterpret_cast<const char*>(event.data.data()), event.data.size()});
}

bool is_decodable(const LogEvent& event) {
  const auto sensor = sensors().find(event.channel);
  const LcmType* type =
      sensor != sensors().end() ? sensor->second : peek_type(event.data.data(), event.data.size());
  return type != nullptr && !check(*type, event.data.data(), event.data.size());
}

}  // namespace

bool is_sensor_channel(const std::string& channel) { return sensors().count(channel) > 0; }

struct Conductor::Peers {
  std::mutex mutex;
  std::condition_variable changed;
  std::map<std::string, status_t> last;

  void hear(const status_t& status) {
    const std::lock_guard<std::mutex> lock(mutex);
    status_t& known = last[status.process];
    if (known.pid == status.pid && status.seq < known.seq) return;  // overtaken on the network
    known = status;
    changed.notify_all();
  }
};

Conductor::Conductor(Bus& bus, ConductorOptions options, std::function<void()> poll)
    : bus_(bus),
      options_(std::move(options)),
      poll_(std::move(poll)),
      shared_(std::make_shared<Peers>()) {
  bus_.listen<status_t>("STATUS", [peers = shared_, names = options_.processes](const status_t& m) {
    if (std::find(names.begin(), names.end(), m.process) != names.end()) peers->hear(m);
  });
  // In throughput mode listeners learn from our STATUS what they lack; lockstep has STEP for that.
  if (options_.mode == Mode::kThroughput) bus_.handle(0);
}

bool Conductor::wait(const std::function<bool()>& ready, const std::string& what) {
  auto last_change = Clock::now();
  std::string last_state;
  std::unique_lock<std::mutex> lock(shared_->mutex);
  while (!ready()) {
    const bool told = shared_->changed.wait_for(lock, kPollPeriod) == std::cv_status::no_timeout;
    if (told && ready()) break;
    lock.unlock();
    poll_();
    lock.lock();
    std::string state = who_lags();
    if (state != last_state) {
      last_state = std::move(state);
      last_change = Clock::now();
    } else if (Clock::now() - last_change > std::chrono::seconds(options_.stall_timeout_s)) {
      throw std::runtime_error(std::string(what)
                                   .append(": no progress for ")
                                   .append(std::to_string(options_.stall_timeout_s))
                                   .append(" s; waiting for ")
                                   .append(last_state));
    }
  }
  return true;
}

void Conductor::wait_for_processes(int timeout_s) {
  const auto deadline = Clock::now() + std::chrono::seconds(timeout_s);
  std::unique_lock<std::mutex> lock(shared_->mutex);
  for (;;) {
    std::string absent;
    for (const std::string& name : options_.processes) {
      const auto peer = shared_->last.find(name);
      if (peer == shared_->last.end() || peer->second.state != status_t::RUNNING)
        absent += " " + name;
    }
    if (absent.empty()) return;
    if (Clock::now() > deadline)
      throw std::runtime_error("not ready within " + std::to_string(timeout_s) + " s:" + absent +
                               ". If they run, their messages don't arrive: `fusion-slam doctor` "
                               "tells why");
    shared_->changed.wait_for(lock, kPollPeriod);
    lock.unlock();
    poll_();
    lock.lock();
  }
}

Conductor::Counts Conductor::counts_locked() const {
  Counts counts = bus_.published();
  if (!ahead_channel_.empty()) --counts[ahead_channel_];
  for (const auto& [name, peer] : shared_->last) {
    const auto behind = behind_.find(name);
    for (const auto& channel : (behind != behind_.end() ? behind->second.before : peer).channels)
      counts[channel.channel] += channel.published;
  }
  for (auto it = counts.begin(); it != counts.end();)
    it = is_control_channel(it->first) ? counts.erase(it) : std::next(it);
  return counts;
}

Conductor::Counts Conductor::counts() const {
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  return counts_locked();
}

std::map<std::string, status_t> Conductor::peers() const {
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  return shared_->last;
}

std::int64_t Conductor::backlog(const status_t& peer, const Counts& counts) {
  std::int64_t sum = 0;
  for (const auto& channel : peer.channels) {
    const auto sent = counts.find(channel.channel);
    if (channel.subscribed != 0 && sent != counts.end())
      sum += std::max<std::int64_t>(0, sent->second - channel.processed);
  }
  return sum;
}

std::string Conductor::who_lags() const {
  std::string text;
  const Counts counts = counts_locked();
  for (const auto& [name, peer] : shared_->last)
    for (const auto& channel : peer.channels) {
      const auto sent = counts.find(channel.channel);
      if (channel.subscribed == 0 || sent == counts.end() || sent->second <= channel.processed)
        continue;
      text += (text.empty() ? "" : ", ") + name + " (" + channel.channel + ": " +
              std::to_string(channel.processed) + " of " + std::to_string(sent->second) +
              " handled, " + std::to_string(channel.received) + " received)";
    }
  return text.empty() ? "nobody" : text;
}

bool Conductor::must_catch_up(const std::string& name, const Counts& counts, bool all) const {
  const Behind& behind = behind_.at(name);
  if (all || behind.events >= options_.most_behind) return true;
  const auto& channels = behind.before.channels;
  return std::any_of(channels.begin(), channels.end(), [&](const channel_stats_t& channel) {
    const auto sent = counts.find(channel.channel);
    const auto given = behind.given.find(channel.channel);
    return channel.subscribed != 0 && sent != counts.end() &&
           sent->second > (given != behind.given.end() ? given->second : 0);
  });
}

// Waits for those who are behind and must not be any longer; true when there were any.
bool Conductor::catch_up(bool all) {
  std::set<std::string> names;
  std::int64_t step = 0;
  {
    const std::lock_guard<std::mutex> lock(shared_->mutex);
    const Counts counts = counts_locked();
    for (const auto& [name, behind] : behind_)
      if (must_catch_up(name, counts, all)) names.insert(name);
  }
  for (const std::string& name : names) {
    step = behind_.at(name).step;
    await_answers({name}, step);
    behind_.erase(name);
  }
  return !names.empty();
}

void Conductor::await_answers(const std::set<std::string>& names, std::int64_t step) {
  auto sent = Clock::now();
  const auto answered = [&] {
    for (const std::string& name : names)
      if (shared_->last[name].step < step) {
        if (Clock::now() - sent > kStepRepeat) {
          bus_.publish("STEP", last_step_);
          sent = Clock::now();
        }
        return false;
      }
    return true;
  };
  wait(answered, "step " + std::to_string(step));
}

void Conductor::step_until_quiet(bool all) {
  n_waiting_ = 0;
  for (;;) {
    if (catch_up(all)) continue;
    step_t message{};
    std::set<std::string> busy;
    Counts counts;
    {
      const std::lock_guard<std::mutex> lock(shared_->mutex);
      counts = counts_locked();
      for (const auto& [name, peer] : shared_->last)
        if (behind_.count(name) == 0 && backlog(peer, counts) > 0) busy.insert(name);
      for (const auto& [channel, count] : counts) {
        message.channels.push_back(channel);
        message.counts.push_back(count);
      }
    }
    if (busy.empty()) return;
    message.n_channels = static_cast<std::int32_t>(message.channels.size());
    message.step = ++step_;
    last_step_ = message;
    for (const std::string& name : options_.behind) {
      if (busy.erase(name) == 0) continue;
      const std::lock_guard<std::mutex> lock(shared_->mutex);
      behind_[name] = {step_, counts, shared_->last[name], 0};
    }
    bus_.publish("STEP", message);
    await_answers(busy, step_);
  }
}

// Whether the event waits for the step of the next. Handlers get it before what is later, as ever;
// what they publish because of it, if anything, comes one event later.
bool Conductor::goes_later(const LogEvent& event) {
  if (options_.mode != Mode::kLockstep || options_.inert.count(event.channel) == 0) return false;
  const auto utime_us = peek_utime(event.data.data(), event.data.size());
  if (!anybody_listens(event.channel)) return true;
  if (!utime_us || n_waiting_ >= kMostWaiting) return false;
  waiting_utime_us_ = n_waiting_ == 0 ? *utime_us : std::max(waiting_utime_us_, *utime_us);
  ++n_waiting_;
  return true;
}

bool Conductor::anybody_listens(const std::string& channel) const {
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  return std::any_of(shared_->last.begin(), shared_->last.end(), [&](const auto& peer) {
    const auto& channels = peer.second.channels;
    return std::any_of(channels.begin(), channels.end(), [&](const channel_stats_t& theirs) {
      return theirs.channel == channel && theirs.subscribed != 0;
    });
  });
}

bool Conductor::was_recent(const std::string& channel, std::size_t hash) const {
  const auto recent = recent_.find(channel);
  return recent != recent_.end() &&
         std::find(recent->second.begin(), recent->second.end(), hash) != recent->second.end();
}

bool Conductor::all_have_locked(const std::string& channel, std::int64_t count) const {
  return std::none_of(shared_->last.begin(), shared_->last.end(), [&](const auto& peer) {
    const auto& channels = peer.second.channels;
    return std::any_of(channels.begin(), channels.end(), [&](const channel_stats_t& theirs) {
      return theirs.channel == channel && theirs.subscribed != 0 && theirs.received < count;
    });
  });
}

// Only what play() will certainly send, and as it would. Not before all say that they have the
// message before it: messages without a number are counted, and this would be taken for a lost one.
void Conductor::send_ahead(const LogEvent& event) {
  const auto published = bus_.published();
  const auto mine = published.find(event.channel);
  if (options_.mode != Mode::kLockstep || !ahead_channel_.empty() || mine == published.end() ||
      peek_seq(event.data.data(), event.data.size()) || !is_decodable(event) ||
      was_recent(event.channel, hash_of(event)))
    return;
  {
    const std::lock_guard<std::mutex> lock(shared_->mutex);
    if (!all_have_locked(event.channel, mine->second)) return;
  }
  ahead_channel_ = event.channel;
  ahead_event_ = {event.offset_bytes, event.number};
  bus_.publish_bytes(event.channel, event.data);
}

bool Conductor::is_repeat(const LogEvent& event) {
  if (peek_seq(event.data.data(), event.data.size())) return false;
  const std::size_t hash = hash_of(event);
  if (was_recent(event.channel, hash)) return true;
  auto& recent = recent_[event.channel];
  recent.push_back(hash);
  if (recent.size() > kRepeatMemory) recent.pop_front();
  return false;
}

Played Conductor::play(const LogEvent& event, const LogEvent* next) {
  const bool is_there = ahead_channel_ == event.channel &&
                        ahead_event_ == std::pair(event.offset_bytes, event.number);
  if (!is_there && !is_decodable(event)) return Played::kUndecodable;
  if (is_repeat(event)) return Played::kRepeat;
  const auto utime_us = peek_utime(event.data.data(), event.data.size());
  if (n_waiting_ > 0 && options_.inert.count(event.channel) == 0 &&
      (!utime_us || *utime_us <= waiting_utime_us_))
    step_until_quiet();
  if (event.channel == "CAMERA" || event.channel == "LIDAR")
    for (auto& [name, behind] : behind_) ++behind.events;
  const auto published = bus_.published();
  const auto mine = published.find(event.channel);
  const bool first = mine == published.end();
  if (options_.mode == Mode::kThroughput && !first && event.data.size() > kOneDatagram)
    // A message of many datagrams is the one that a full buffer loses. Its listeners learn that
    // from our next STATUS; what came after it on its channel would be handled by then.
    wait([&] { return all_have_locked(event.channel, mine->second); }, "replay");
  if (is_there)
    ahead_channel_.clear();
  else
    bus_.publish_bytes(event.channel, renumbered(event, first ? 1 : mine->second + 1));
  if (next != nullptr) send_ahead(*next);
  poll_();
  if (goes_later(event)) return Played::kYes;
  if (options_.mode == Mode::kLockstep) {
    step_until_quiet();
  } else {
    // Nobody can miss the first message of a channel before there is a second: a model that got
    // lost would come after the frames that need it.
    const int most = first ? 0 : options_.most_in_flight;
    wait(
        [this, most] {
          const Counts counts = counts_locked();
          return std::all_of(shared_->last.begin(), shared_->last.end(), [&](const auto& peer) {
            return backlog(peer.second, counts) <= most;
          });
        },
        "replay");
  }
  return Played::kYes;
}

void Conductor::command(const std::string& verb, std::int64_t utime_us) {
  settle();
  command_t message{};
  message.utime = utime_us;
  message.verb = verb;
  bus_.publish("COMMAND", message);
  settle();
}

void Conductor::settle() {
  if (options_.mode == Mode::kLockstep) return step_until_quiet(true);
  // A process may be about to publish: quiet is when two looks, a status apart, see the same counts
  // and no backlog.
  Counts before;
  for (;;) {
    wait(
        [this] {
          const Counts counts = counts_locked();
          return std::all_of(shared_->last.begin(), shared_->last.end(),
                             [&](const auto& peer) { return backlog(peer.second, counts) == 0; });
        },
        "settle");
    const Counts now = counts();
    if (now == before) return;
    before = now;
    std::this_thread::sleep_for(kPollPeriod);
  }
}

}  // namespace fusion_slam
