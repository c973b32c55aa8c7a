#include "libs/bus/bus.hpp"

#include <algorithm>
#include <iostream>
#include <utility>

#include "libs/bus/bus_internal.hpp"
#include "libs/clock/clock.hpp"
#include "libs/schema/guard.hpp"

namespace fusion_slam {

Bus::Bus(const BusOptions& options) : Bus(options, std::make_shared<Transport>(options.url)) {}

Bus::Bus(BusOptions options, std::shared_ptr<Transport> transport)
    : impl_(std::make_unique<Impl>(std::move(options), std::move(transport))) {
  impl_->start();
}

Bus::~Bus() {
  impl_->stopping = true;
  impl_->changed.notify_all();
  impl_->tokens.clear();
}

void Bus::subscribe_raw(const std::string& channel, std::uint64_t fingerprint, Policy policy,
                        Decode decode) {
  const LcmType* type = builtin_schema().find(fingerprint);
  std::size_t index = 0;
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    // Several people may send commands, each numbering its own.
    const bool numbered = type->continues_with_seq && channel != "COMMAND";
    index = impl_->inbox.add_channel(channel, policy, numbered);
    impl_->handlers.push_back({type, std::move(decode)});
  }
  impl_->tokens.push_back(impl_->transport->subscribe(
      channel, [impl = impl_.get(), index, gate = impl_->gate_for(channel)](
                   const std::string&, const std::uint8_t* bytes, std::size_t size) {
        if (impl->admit(gate.get(), bytes, &size)) return impl->receive(index, bytes, size);
        const std::lock_guard<std::mutex> lock(impl->mutex);
        ++impl->inbox.channels()[index].counters.rejected;
      }));
}

void Bus::never_await(const std::set<std::string>& channels) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  for (auto& channel : impl_->inbox.channels())
    if (channels.count(channel.name) != 0) channel.awaited = false;
}

void Bus::listen_raw(const std::string& channel, std::uint64_t fingerprint, Decode decode) {
  impl_->listen(channel, builtin_schema().find(fingerprint), std::move(decode));
}

void Bus::publish_raw(const std::string& channel,
                      const std::function<std::vector<std::uint8_t>(std::int64_t)>& encode) {
  if (impl_->recovering) return;
  impl_->pace();
  const std::lock_guard<std::mutex> lock(impl_->out_mutex);
  auto bytes = encode(impl_->outbox.next_seq(channel));
  impl_->write_said(channel, bytes);
  if (impl_->key && channel == "COMMAND") bytes = sign_command(*impl_->key, bytes, wall_us());
  impl_->outbox.sent(channel, bytes);
  impl_->send(channel, bytes);
}

void Bus::publish_bytes(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  publish_raw(channel, [&bytes](std::int64_t) { return bytes; });
}

// While a journal is read back tiles are kept and not sent: the index says what there is.
void Bus::publish_tile(const std::string& channel, tile_t tile) {
  if (!impl_->recovering) impl_->pace();
  const std::lock_guard<std::mutex> lock(impl_->out_mutex);
  const auto cleared = impl_->cleared_revision.find(channel);
  tile.revision +=
      cleared == impl_->cleared_revision.end() ? impl_->first_revision : cleared->second;
  impl_->send_tile(channel, std::move(tile));
}

void Bus::forget_sent(const std::string& channel) {
  const std::lock_guard<std::mutex> lock(impl_->out_mutex);
  impl_->outbox.forget(channel);
}

void Bus::clear_tiles(const std::string& channel) {
  if (impl_->recovering) return;
  std::vector<tile_t> gone;
  std::int64_t newest = impl_->first_revision;
  {
    const std::lock_guard<std::mutex> lock(impl_->out_mutex);
    for (const auto& bytes : impl_->outbox.tiles(channel)) {
      auto tile = bus_detail::decode<tile_t>(bytes.data(), bytes.size());
      newest = std::max(newest, tile.revision);
      if (tile.encoding != tile_t::EMPTY) gone.push_back(std::move(tile));
    }
    ++newest;
    impl_->cleared_revision[channel] = newest;
  }
  for (tile_t& tile : gone) {
    tile.encoding = tile_t::EMPTY;
    tile.data.clear();
    tile.size_bytes = 0;
    tile.revision = newest;
    impl_->pace();
    const std::lock_guard<std::mutex> lock(impl_->out_mutex);
    impl_->send_tile(channel, std::move(tile));
  }
}

void Bus::Impl::send_tile(const std::string& channel, tile_t tile) {
  tile.seq = outbox.next_seq(channel);
  const auto bytes = bus_detail::encode(tile);
  if (!recovering) write_said(channel, bytes);
  outbox.sent_tile(channel, {tile.submap_id, tile.x, tile.y, tile.z}, tile.revision, bytes);
  if (!recovering) send(channel, bytes);
}

void Bus::run() {
  impl_->open_journal();
  impl_->running = true;
  impl_->send_status();
  const bool is_file = impl_->transport->url().rfind("file://", 0) == 0;
  while (!impl_->stopping) {
    const bool all_read = is_file && impl_->transport->at_end();
    const bool handled = handle(50);
    impl_->call_timers();
    if (all_read && !handled) break;
  }
}

void Bus::stop() { impl_->stopping = true; }

bool Bus::handle(int timeout_ms) {
  impl_->running = true;
  impl_->transport->start();
  if (impl_->options.mode == Mode::kLockstep) return impl_->handle_step(timeout_ms);
  const bool handled = impl_->handle_one(timeout_ms);
  if (handled && impl_->journal_is_large()) impl_->renew_journal();
  return handled;
}

void Bus::every(int period_ms, std::function<void()> callback) {
  impl_->timers.push_back({period_ms * 1000LL, steady_us(), std::move(callback)});
}

void Bus::keep_in_journal(const std::set<std::string>& channels, Recover when) {
  for (const std::string& channel : channels)
    impl_->journal_channels[channel] = when == Recover::kWhenAsked;
}

void Bus::keep_journal_small(JournalNeeds needs) { impl_->needs = std::move(needs); }
bool Bus::renew_journal() { return impl_->renew_journal(); }

void Bus::recover() {
  if (std::exchange(impl_->asked_to_recover, true)) return;
  impl_->read_handled(true);
}
bool Bus::recovering() const { return impl_->recovering; }
std::int64_t Bus::first_revision() const { return impl_->first_revision; }

void Bus::keep_said_raw(const std::string& channel, std::uint64_t fingerprint, bool sent,
                        Decode decode) {
  impl_->said[channel] = {{builtin_schema().find(fingerprint), std::move(decode)}, sent};
}

void Bus::note_raw(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  if (impl_->recovering) return;
  impl_->append_to_journal(channel, bytes);
}

void Bus::set_state_text(const std::string& text) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  impl_->state_text = text;
}

void Bus::report_error(const std::string& text) { impl_->report(text); }

status_t Bus::status() const { return impl_->status(); }
Mode Bus::mode() const { return impl_->options.mode; }

std::map<std::string, std::int64_t> Bus::published() const {
  const std::lock_guard<std::mutex> lock(impl_->out_mutex);
  return impl_->outbox.counts();
}

std::map<std::string, std::int64_t> Bus::processed() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  std::map<std::string, std::int64_t> result;
  for (const auto& channel : impl_->inbox.channels())
    result[channel.name] = channel.counters.processed;
  return result;
}

}  // namespace fusion_slam
