// The inside of Bus: what the reader's thread and the handling thread share. Included by
// libs/bus/*.cpp only.
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>

#include "fusion_slam/command_t.hpp"
#include "fusion_slam/resend_t.hpp"
#include "fusion_slam/step_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/command_gate.hpp"
#include "libs/bus/inbox.hpp"
#include "libs/bus/latency.hpp"
#include "libs/bus/outbox.hpp"
#include "libs/bus/transport.hpp"
#include "libs/journal/journal.hpp"
#include "libs/schema/schema.hpp"

namespace fusion_slam {

struct Bus::Impl {
  Impl(BusOptions options_in, std::shared_ptr<Transport> transport_in);
  void start();  // subscribes to what every process listens to

  // --- reader's thread ---
  void receive(std::size_t index, const std::uint8_t* bytes, std::size_t size);
  bool passes_guard(const std::string& channel, const LcmType& type, const std::uint8_t* bytes,
                    std::size_t size);
  void listen(const std::string& channel, const LcmType* type, Decode decode);
  void decode_safely(const std::string& channel, const Decode& decode, const std::uint8_t* bytes,
                     std::size_t size);
  void on_resend(const resend_t& request);
  void on_step(const step_t& step);
  void on_peer_status(const status_t& peer);
  void restarted_by(const status_t& peer, const channel_stats_t& theirs, Inbox::Channel& mine);
  void idle();  // STATUS, indexes, requests for what is missing, answers to requests
  void request_missing(std::int64_t now);
  void answer_requests(std::int64_t now);
  void send_resend(resend_t message);  // out_mutex held

  // --- handling thread ---
  bool handle_one(int timeout_ms);
  bool handle_step(int timeout_ms);
  void handle_item(const InboxItem& item);
  void call_timers();

  // --- any thread ---
  void pace();  // sleeps when a burst has been sent; out_mutex not held
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes);  // out_mutex held
  void report(const std::string& text);
  status_t status() const;
  void send_status();

  std::optional<SigningKey> key;
  std::int64_t started_us = 0;  // wall clock
  // One for each subscription of COMMAND; nothing: the message is refused.
  std::shared_ptr<CommandGate> gate_for(const std::string& channel) const;
  bool admit(CommandGate* gate, const std::uint8_t* bytes, std::size_t* size);

  struct Handler {
    const LcmType* type = nullptr;
    Decode decode;
  };
  struct Timer {
    std::int64_t period_us = 0;
    std::int64_t last_us = 0;
    std::function<void()> callback;
  };
  // What a peer's STATUS said of a channel whose messages carry no number.
  struct Peer {
    std::int32_t pid = 0;
    std::string host;
    std::int64_t base = 0;       // its count minus ours when we first heard of it
    std::int64_t published = 0;  // a second ago
  };

  BusOptions options;
  std::shared_ptr<Transport> transport;
  std::atomic<bool> stopping{false};
  std::atomic<bool> running{false};

  mutable std::mutex mutex;  // of the inbox side
  std::condition_variable changed;
  Inbox inbox;
  std::vector<Handler> handlers;
  std::map<std::string, std::int64_t> listened_rejected;
  std::deque<step_t> steps;
  std::int64_t step_done = 0;
  LatencyHistogram latency;
  std::string state_text;
  std::string last_error;
  std::int64_t error_count = 0;
  std::map<std::string, Peer> peers;
  std::map<std::size_t, std::int64_t> requested_us;

  std::mutex status_mutex;  // of send_status, taken before the others

  mutable std::mutex out_mutex;  // of the outbox side
  Outbox outbox;
  std::int64_t first_revision = 0;  // live: added to tiles', larger than an earlier process's
  // By channel, after clear_tiles(): added instead, larger than any that was sent.
  std::map<std::string, std::int64_t> cleared_revision;
  void send_tile(const std::string& channel, tile_t tile);  // out_mutex held; revision as it is
  std::int64_t burst_begin_us = 0;
  int burst_messages = 0;
  std::size_t burst_bytes = 0;

  struct Said {  // a channel that this process publishes
    Handler handler;
    bool sent = false;  // false: notes, for the journal alone
  };
  void open_journal();           // hands over what is in it, or waits with that until recover()
  void mark_journal(bool cut);   // journal_mutex held
  static std::string boot_id();  // another one after each start of the machine; empty: unknown
  void skip_lost_numbers();
  void read_said();
  void read_handled(bool when_asked);
  void write_to_journal(const InboxItem& item);
  void write_said(const std::string& channel, const std::vector<std::uint8_t>& bytes);
  void append_to_journal(const std::string& channel, const std::vector<std::uint8_t>& bytes);
  void hand_over(const std::string& channel, const Handler& handler, const LogEvent& event);
  // Of a channel that is heard and journalled: what of it is in the journal.
  struct Heard {
    SequenceTracker sequence{false};  // numbers handled, by this process or before
    std::int64_t newest_utime_us = 0;
    std::int64_t told_upto = 0;  // by the mark of an earlier renewal
    std::int64_t told_utime_us = 0;
    std::set<std::int64_t> told_missing;
    std::vector<std::uint8_t> first;  // message, when that is what is needed
    std::map<std::int64_t, std::pair<std::int64_t, std::int64_t>> at;  // number: offset, record
  };
  // bus_journal_renewal.cpp
  bool journal_is_large();
  bool renew_journal();
  bool keep_said_and_heard();  // in the new file
  bool keep_heard(const std::string& channel, Heard* there);
  bool mark_anew(const char* verb, const std::string& channel, std::int64_t utime_us,
                 const std::vector<std::int64_t>& numbers);
  void tell_said(const command_t& mark);
  // `at`: the record's. False: a mark of an earlier renewal has told its number.
  bool was_heard(const std::string& channel, const std::vector<std::uint8_t>& bytes,
                 const JournalState& at);
  std::vector<std::int64_t> tell_heard(const command_t& mark);
  bool append_anew(const std::string& channel, const std::vector<std::uint8_t>& bytes);
  std::optional<JournalNeeds> needs;
  std::map<std::string, Heard> heard;    // journal_mutex
  std::int64_t journal_limit_bytes = 0;  // 0: not known yet
  bool renewing = false;                 // notes go into the new file; handling thread
  bool renewal_failed = false;

  std::map<std::string, bool> journal_channels;  // true: handed over when asked
  std::map<std::string, Said> said;
  bool asked_to_recover = false;
  std::int64_t n_to_recover = 0;  // records of earlier processes
  std::mutex journal_mutex;       // taken last
  std::unique_ptr<Journal> journal;
  std::atomic<bool> recovering{false};  // what is published goes nowhere

  std::vector<Timer> timers;  // handling thread only
  std::atomic<std::int64_t> last_status_us{0};
  std::int64_t last_index_us = 0;
  std::int64_t last_answer_us = 0;
  std::atomic<std::int64_t> told_activity{-1};
  std::atomic<std::int64_t> activity{0};      // grows with each message handled or sent
  std::vector<std::shared_ptr<void>> tokens;  // last: destroyed first
};

}  // namespace fusion_slam
