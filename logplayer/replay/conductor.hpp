// Plays sensor events to the processes of a run and knows when they have digested them.
//
// Lockstep, after an event: every process handles in one step the messages that the step before
// brought forth (bulk synchronous processing, Valiant 1990), in canonical order, until no message
// is unhandled. What a process sees therefore depends on the log alone, not on the network's or the
// scheduler's timing. Two things save waiting and leave that so: what brings forth hardly anything
// (`inert`) is handled in the step of the next later event; and processes that no pose
// waits for
// (`behind`) may work on while others go on, until there is new work for them or a number of sensor
// events has been played: only then is what they have published counted. Throughput: a bounded
// number of messages is in flight; the first of each channel is handled by all before the next is
// sent.
//
// All methods from one thread.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "fusion_slam/step_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/eventlog/event.hpp"

namespace fusion_slam {

struct ConductorOptions {
  Mode mode = Mode::kLockstep;         // or kThroughput
  std::vector<std::string> processes;  // names in STATUS of those who must digest everything
  std::set<std::string> inert;         // lockstep: channels whose handlers publish hardly anything
  std::set<std::string> behind;        // lockstep: those of them that others need not wait for
  int most_behind = 2;                 // events of camera or LiDAR
  int most_in_flight = 24;             // throughput: unhandled messages a process may have
  int stall_timeout_s = 120;           // no progress at all for this long is an error
};

enum class Played { kYes, kRepeat, kUndecodable };

class Conductor {
 public:
  // `poll` is called at least every 50 ms while waiting; it throws to end the wait (a process died,
  // Ctrl-C).
  Conductor(Bus& bus, ConductorOptions options, std::function<void()> poll);

  // Returns when every process has said that it runs. Throws std::runtime_error naming those that
  // don't within timeout_s.
  void wait_for_processes(int timeout_s);

  // Sends one event of a log. Lockstep: returns when all is quiet again. Throughput: returns when
  // there is room for the next. Not sent are an exact repeat of a recent message of the same
  // channel (receivers could not tell it from a re-send) and what is no message of the channel's
  // type (they would reject it, and it would look like a loss).
  // `next`: null, or an event whose turn comes later, of a channel that has been played before. In
  // lockstep it is sent already now: its receivers may prepare for it while they wait for others;
  // no step counts it before its own play(). One at a time.
  Played play(const LogEvent& event, const LogEvent* next = nullptr);

  // Sends COMMAND `verb` to all and returns when all is quiet.
  void command(const std::string& verb, std::int64_t utime_us);

  // Returns when every message sent so far by anybody is handled.
  void settle();

  std::map<std::string, status_t> peers() const;  // what each process said last
  // Messages sent on each channel so far, by all.
  std::map<std::string, std::int64_t> counts() const;

 private:
  using Counts = std::map<std::string, std::int64_t>;
  // A process of `behind` at work on a step.
  struct Behind {
    std::int64_t step = 0;
    Counts given;     // what the step told it to handle
    status_t before;  // what it had published then
    int events = 0;   // of camera or LiDAR, played since
  };
  bool wait(const std::function<bool()>& ready, const std::string& what);
  Counts counts_locked() const;
  bool goes_later(const LogEvent& event);
  bool anybody_listens(const std::string& channel) const;
  bool must_catch_up(const std::string& name, const Counts& counts, bool all) const;
  static std::int64_t backlog(const status_t& peer, const Counts& counts);
  std::string who_lags() const;
  bool catch_up(bool all);
  void step_until_quiet(bool all = false);
  void await_answers(const std::set<std::string>& names, std::int64_t step);
  bool all_have_locked(const std::string& channel, std::int64_t count) const;
  bool was_recent(const std::string& channel, std::size_t hash) const;
  bool is_repeat(const LogEvent& event);
  void send_ahead(const LogEvent& event);

  Bus& bus_;
  ConductorOptions options_;
  std::function<void()> poll_;
  std::int64_t step_ = 0;
  step_t last_step_{};
  std::map<std::string, Behind> behind_;
  // Inert events that no step has counted yet.
  int n_waiting_ = 0;
  std::int64_t waiting_utime_us_ = 0;  // of the newest
  std::map<std::string, std::deque<std::size_t>> recent_;
  // What was sent ahead: its channel (empty: nothing) and its place in the log.
  std::string ahead_channel_;
  std::pair<std::int64_t, std::int64_t> ahead_event_;

  struct Peers;  // shared with the bus's listener, which may outlive this object
  std::shared_ptr<Peers> shared_;
};

// Channels of a log that are a sensor's: what a replay plays, whatever else the log holds.
bool is_sensor_channel(const std::string& channel);

}  // namespace fusion_slam
