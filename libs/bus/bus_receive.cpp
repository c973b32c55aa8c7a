// The reader's side of the Bus: guard, queues, repair of losses, STATUS.
#include <chrono>
#include <exception>
#include <iostream>
#include <utility>

#include "libs/bus/bus_internal.hpp"
#include "libs/clock/clock.hpp"
#include "libs/schema/guard.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kStatusPeriod_us = 1'000'000;
constexpr std::int64_t kBusyStatusPeriod_us = 4'000;  // throughput: a replay waits for our counts
constexpr std::int64_t kIndexPeriod_us = 500'000;
constexpr std::int64_t kGapAge_us = 15'000;  // reordering on a network is over by then
constexpr std::int64_t kRequestPeriod_us = 40'000;
constexpr std::int64_t kGiveUp_us = 2'000'000;
constexpr std::size_t kMostRequested = 1000;
constexpr std::size_t kOneDatagram = 65'000;  // as the replay's (logplayer/replay/conductor.cpp)
// At most so much per period: a burst must fit the asker's socket buffer.
constexpr std::size_t kAnswerBytes = 256 << 10;
constexpr std::int64_t kAnswerPeriod_us = 2'000;

}  // namespace

bool Bus::Impl::passes_guard(const std::string& channel, const LcmType& type,
                             const std::uint8_t* bytes, std::size_t size) {
  const auto reason = check(type, bytes, size);
  if (!reason) return true;
  report("channel " + channel + ": message of " + std::to_string(size) +
         " bytes rejected: " + *reason);
  return false;
}

std::shared_ptr<CommandGate> Bus::Impl::gate_for(const std::string& channel) const {
  return channel == "COMMAND" ? std::make_shared<CommandGate>(key, started_us) : nullptr;
}

bool Bus::Impl::admit(CommandGate* gate, const std::uint8_t* bytes, std::size_t* size) {
  if (gate == nullptr) return true;
  std::string why;
  const auto message_size = gate->admit(bytes, *size, wall_us(), &why);
  if (!message_size) {
    report(why);
    return false;
  }
  *size = *message_size;
  return true;
}

void Bus::Impl::listen(const std::string& channel, const LcmType* type, Decode decode) {
  tokens.push_back(transport->subscribe(
      channel, [this, type, decode = std::move(decode), gate = gate_for(channel)](
                   const std::string& name, const std::uint8_t* bytes, std::size_t size) {
        if (admit(gate.get(), bytes, &size) && passes_guard(name, *type, bytes, size))
          return decode_safely(name, decode, bytes, size);
        const std::lock_guard<std::mutex> lock(mutex);
        ++listened_rejected[name];
      }));
}

void Bus::Impl::decode_safely(const std::string& channel, const Decode& decode,
                              const std::uint8_t* bytes, std::size_t size) {
  try {
    decode(bytes, size);
  } catch (const std::exception& error) {
    report("channel " + channel + ": " + error.what());
  }
}

void Bus::Impl::receive(std::size_t index, const std::uint8_t* bytes, std::size_t size) {
  const LcmType* type = nullptr;
  std::string name;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    type = handlers[index].type;
    name = inbox.channels()[index].name;
  }
  if (!passes_guard(name, *type, bytes, size)) {
    const std::lock_guard<std::mutex> lock(mutex);
    ++inbox.channels()[index].counters.rejected;
    return;
  }
  InboxItem item;
  item.channel = index;
  item.utime_us = type->starts_with_utime ? peek_utime(bytes, size).value_or(0) : 0;
  item.seq = type->continues_with_seq ? peek_seq(bytes, size).value_or(0) : 0;
  item.arrival_us = steady_us();
  item.bytes.assign(bytes, bytes + size);
  std::unique_lock<std::mutex> lock(mutex);
  if (type->continues_with_seq && item.seq < 1) {
    ++inbox.channels()[index].counters.rejected;
    return;
  }
  // A log file has no clock of its own: wait for the handlers.
  while (transport->url().rfind("file://", 0) == 0 && inbox.waiting() > 256 && !stopping)
    changed.wait_for(lock, std::chrono::milliseconds(20));
  inbox.push(std::move(item));
  changed.notify_all();
  if (options.mode != Mode::kLockstep || type->continues_with_seq || size <= kOneDatagram) return;
  lock.unlock();
  send_status();  // a replay sends the next such message when it knows that this one is here
}

void Bus::Impl::on_resend(const resend_t& request) {
  {
    const std::lock_guard<std::mutex> lock(out_mutex);
    outbox.request(request);
  }
  // A publisher's answer: from and to of numbers that were never given.
  const std::lock_guard<std::mutex> lock(mutex);
  for (auto& mine : inbox.channels())
    for (std::size_t i = 0; mine.name == request.channel && i + 1 < request.seqs.size(); i += 2)
      if (request.seqs[i] < 0 && request.seqs[i + 1] < 0)
        mine.sequence.never_given(-request.seqs[i], -request.seqs[i + 1]);
}

void Bus::Impl::on_step(const step_t& step) {
  std::unique_lock<std::mutex> lock(mutex);
  if (step.step == step_done) {  // asked again: our answer was lost
    lock.unlock();
    return send_status();
  }
  if (step.step < step_done || (!steps.empty() && step.step <= steps.back().step)) return;
  const std::int64_t now = steady_us();
  for (std::size_t i = 0; i < step.channels.size(); ++i)
    inbox.expect(step.channels[i], step.counts[i], now);
  steps.push_back(step);
  changed.notify_all();
}

void Bus::Impl::on_peer_status(const status_t& peer) {
  if (peer.process == options.process) return;
  const std::lock_guard<std::mutex> lock(mutex);
  const std::int64_t now = steady_us();
  for (const auto& theirs : peer.channels) {
    if (theirs.published == 0) continue;
    for (auto& mine : inbox.channels()) {
      if (mine.name != theirs.channel) continue;
      if (mine.has_seq && options.mode == Mode::kLive) restarted_by(peer, theirs, mine);
      if (mine.has_seq || options.mode != Mode::kLive) {
        inbox.expect(mine.name, theirs.published, now);
        continue;
      }
      // What it had sent a second ago should be here by now.
      Peer& known = peers[peer.process + "/" + mine.name];
      if (known.pid != peer.pid)
        known = {peer.pid, peer.host, theirs.published - mine.counters.received, theirs.published};
      const std::int64_t lost = known.published - known.base - mine.counters.received;
      mine.counters.lost = std::max(mine.counters.lost, lost);
      known.published = theirs.published;
    }
  }
}

// Another process of this name counts lower than the one before: its numbers are new ones, even
// when no measurement is newer (tiles of a map that stands still).
void Bus::Impl::restarted_by(const status_t& peer, const channel_stats_t& theirs,
                             Inbox::Channel& mine) {
  Peer& known = peers[peer.process + "/" + mine.name];
  const std::int64_t before = known.published;
  const bool another = known.pid != 0 && (known.pid != peer.pid || known.host != peer.host);
  known.pid = peer.pid;
  known.host = peer.host;
  known.published = theirs.published;
  // Below: a newer measurement has begun the new stream already.
  if (another && theirs.published < before && mine.sequence.highest() >= before)
    mine.sequence.restart();
}

void Bus::Impl::request_missing(std::int64_t now) {
  std::vector<resend_t> requests;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    for (std::size_t i = 0; i < inbox.channels().size(); ++i) {
      auto& channel = inbox.channels()[i];
      const bool repair = channel.policy == Policy::kKeepAll;
      if (options.mode == Mode::kLive)
        channel.counters.lost += static_cast<std::int64_t>(
            channel.sequence.give_up(now, repair ? kGiveUp_us : kGapAge_us));
      if (!repair || now - requested_us[i] < kRequestPeriod_us) continue;
      resend_t request{};
      request.seqs = inbox.missing(i, now, kGapAge_us, kMostRequested);
      if (request.seqs.empty()) continue;
      requested_us[i] = now;
      request.channel = channel.name;
      request.n_seqs = static_cast<std::int32_t>(request.seqs.size());
      requests.push_back(std::move(request));
    }
  }
  for (resend_t& request : requests) {
    const std::lock_guard<std::mutex> lock(out_mutex);
    send_resend(std::move(request));
  }
}

void Bus::Impl::send_resend(resend_t message) {
  message.utime = wall_us();
  message.requester = options.process;
  message.seq = outbox.next_seq("RESEND");
  const auto bytes = bus_detail::encode(message);
  outbox.sent_once("RESEND", bytes.size());
  transport->publish("RESEND", bytes);
}

void Bus::Impl::answer_requests(std::int64_t now) {
  if (now - last_answer_us < kAnswerPeriod_us) return;
  last_answer_us = now;
  const std::lock_guard<std::mutex> lock(out_mutex);
  for (resend_t& answer : outbox.take_never_given()) send_resend(std::move(answer));
  for (std::size_t sent = 0; sent < kAnswerBytes;) {
    const auto message = outbox.take_requested();
    if (!message) return;
    transport->publish(message->first, message->second);
    sent += message->second.size();
  }
}

void Bus::Impl::idle() {
  const std::int64_t now = steady_us();
  request_missing(now);
  answer_requests(now);
  if (!running) return;
  const bool busy = options.mode == Mode::kThroughput && told_activity != activity &&
                    now - last_status_us >= kBusyStatusPeriod_us;
  if (busy || now - last_status_us >= kStatusPeriod_us) send_status();
  if (now - last_index_us < kIndexPeriod_us) return;
  last_index_us = now;
  const std::lock_guard<std::mutex> lock(out_mutex);
  for (tile_index_t& index : outbox.indexes()) {
    const std::string channel = index.channel + "_INDEX";
    index.utime = wall_us();
    index.seq = outbox.next_seq(channel);
    const auto bytes = bus_detail::encode(index);
    outbox.sent_once(channel, bytes.size());
    transport->publish(channel, bytes);
  }
}

}  // namespace fusion_slam
