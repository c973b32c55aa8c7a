// The only door to LCM. A process owns one Bus: it subscribes with a policy per channel, publishes
// with sequence numbers, answers RESEND, says STATUS at 1 Hz, and hands messages to its callbacks
// on the thread that calls run(), merged by measurement time. Callbacks never run at the same time
// as each other.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "fusion_slam/status_t.hpp"
#include "fusion_slam/tile_t.hpp"
#include "libs/bus/policy.hpp"

namespace fusion_slam {

struct BusOptions {
  std::string url;      // udpm://, memq://, file://; empty: LCM_DEFAULT_URL or LCM's default
  std::string process;  // name in STATUS
  Mode mode = Mode::kLive;
  std::size_t keep_all_bound = 4096;  // messages a channel
  std::int64_t merge_wait_us =
      30'000;           // live: how long a message waits for older ones of other channels
  std::string journal;  // file of keep_in_journal(); empty: none. Live only
  // Live: COMMAND is signed, and taken, with the key in this file; empty: FUSION_SLAM_KEY_FILE,
  // else no key: nothing is signed and everything is taken.
  std::string key_file;
};

class Transport;  // an LCM handle and its reader thread; several buses of one process may share one
                  // (memq)

// Thread-safe where noted; otherwise to be called from the thread that runs run().
class Bus {
 public:
  // Throws std::runtime_error with what to do when the network can't be opened.
  explicit Bus(const BusOptions& options);
  Bus(BusOptions options, std::shared_ptr<Transport> transport);
  ~Bus();
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  // Handler of one type on one channel (A-Z, 0-9, _). Must be called before run(). Messages that
  // fail the decoder guard never reach the handler: they are counted and reported. A handler that
  // throws ends run() with that exception.
  template <class Message>
  void subscribe(const std::string& channel, Policy policy,
                 std::function<void(const Message&)> handler);

  // Live: no message waits until these channels have spoken of its time, too. For those that answer
  // what this process says (nothing of a time can come that it has not handled), those whose sender
  // says them before others of the same time, and those whose order does not matter. Before run(),
  // after subscribe().
  void never_await(const std::set<std::string>& channels);

  // Sends a message; fills `seq` when the type has one. May be called from any thread.
  template <class Message>
  void publish(const std::string& channel, Message message);

  // Handles messages until stop() or COMMAND quit. Installs nothing: main() turns signals into
  // stop().
  void run();
  void stop();  // any thread, and signal handlers

  // Handles what is waiting now without blocking longer than timeout_ms; true when something was
  // handled. For who has a loop of its own instead of run(): from the first call on STATUS is sent.
  bool handle(int timeout_ms);

  // Called in run() about every `period_ms` of wall time between messages (live and throughput
  // modes only): for publishing state to people. Algorithms must not depend on it.
  void every(int period_ms, std::function<void()> callback);

  // Messages of these channels, which must be subscribed, are written to the journal before they
  // are handled. run() first hands over what an earlier process wrote there: what is published
  // meanwhile goes nowhere, and numbers that are missing since are asked for. Nothing happens
  // without a journal, or in replay modes.
  // kWhenAsked: not run() but recover() hands these channels over, for who needs something else
  // first. May be called once for each of the two.
  enum class Recover { kAtOnce, kWhenAsked };
  void keep_in_journal(const std::set<std::string>& channels, Recover when = Recover::kAtOnce);
  void recover();           // kWhenAsked, from a handler; the second time nothing happens
  bool recovering() const;  // a handler is given what an earlier process has handled
  // What is published on this channel is written to the journal before it is sent. run() hands to
  // `handler` what an earlier process said; its numbers go on, and RESEND and tile indexes answer
  // for it. Before run(); the handlers of subscribed channels come in the order of the records.
  template <class Message>
  void keep_said(const std::string& channel, std::function<void(const Message&)> handler);
  // A record in the journal alone, and where it goes when it is read back.
  template <class Message>
  void note(const std::string& channel, const Message& message);
  template <class Message>
  void on_note(const std::string& channel, std::function<void(const Message&)> handler);
  // What a restart needs of the journal, when that is less than all.
  struct JournalNeeds {
    std::set<std::string> first_of;  // of these channels the first message is enough (models)
    // Numbers of the messages of other channels in keep_in_journal() that are still needed. What
    // has no number is not.
    std::function<std::set<std::int64_t>(const std::string& channel)> numbers;
    // Calls note() with everything that on_note() of a restart has to be given.
    std::function<void()> note_state;
  };
  // The journal grows with what there is to keep, not with time: grown to twice of what was kept
  // last (64 MB at least) it is written anew, with that and, of what was said, with what RESEND can
  // still be answered by. All numbers go on. Not for who keeps tiles it has said. Before run().
  void keep_journal_small(JournalNeeds needs);
  // The same at once, for tests; from the thread of run(), or when it has ended. False: there is no
  // journal, or its disk is full.
  bool renew_journal();
  // Live: larger than any that an earlier process of this name can have begun with (seconds since
  // 1970 times a million, or above what its journal holds). Replays: 0.
  std::int64_t first_revision() const;

  // Shown in STATUS until changed; any thread.
  void set_state_text(const std::string& text);
  void report_error(const std::string& text);

  status_t status() const;  // what STATUS would say now; any thread
  Mode mode() const;

  // --- for tools: replay, viewers, tile channels ---
  // Bytes as they stand in a log. Counted like publish().
  void publish_bytes(const std::string& channel, const std::vector<std::uint8_t>& bytes);
  // Sends a tile and keeps it: the newest of each key is sent again to whoever asks, and
  // <CHANNEL>_INDEX says what there is.
  void publish_tile(const std::string& channel, tile_t tile);
  // What was sent on the channel is not sent again to whoever asks for it by number.
  void forget_sent(const std::string& channel);
  // Says of every tile of the channel that it is gone (EMPTY, newer than any before). Tiles that
  // follow may count their revisions from 1 again.
  void clear_tiles(const std::string& channel);
  // Handler called on the reader's thread at once, outside lockstep and queues; for STATUS, RESEND
  // and the like.
  template <class Message>
  void listen(const std::string& channel, std::function<void(const Message&)> handler);
  std::map<std::string, std::int64_t> published()
      const;  // messages sent so far by channel; any thread
  std::map<std::string, std::int64_t> processed()
      const;  // messages handled so far by channel; any thread

 private:
  struct Impl;
  using Decode = std::function<void(const std::uint8_t* bytes, std::size_t size_bytes)>;
  void subscribe_raw(const std::string& channel, std::uint64_t fingerprint, Policy policy,
                     Decode decode);
  void keep_said_raw(const std::string& channel, std::uint64_t fingerprint, bool sent,
                     Decode decode);
  void note_raw(const std::string& channel, const std::vector<std::uint8_t>& bytes);
  void listen_raw(const std::string& channel, std::uint64_t fingerprint, Decode decode);
  // Fills and sends under one lock, so that numbers go out in order.
  void publish_raw(const std::string& channel,
                   const std::function<std::vector<std::uint8_t>(std::int64_t seq)>& encode);
  std::unique_ptr<Impl> impl_;
};

}  // namespace fusion_slam

#include "libs/bus/bus_templates.hpp"  // IWYU pragma: keep
