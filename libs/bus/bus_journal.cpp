// The Bus's journal: a live process that is killed and started again first takes back what it had
// said, then handles again what it had handled.
#include <algorithm>
#include <fstream>
#include <iostream>
#include <vector>

#include "libs/bus/bus_internal.hpp"
#include "libs/bus/journal_mark.hpp"
#include "libs/clock/clock.hpp"
#include "libs/schema/guard.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kRevisionStep = 1'000'000;  // more tiles than one process makes of a key

command_t mark_from(const LogEvent& event) {
  command_t mark{};
  if (mark.decode(event.data.data(), 0, static_cast<int>(event.data.size())) < 0) return {};
  return mark;
}

// Reads at most so many records.
template <class OnRecord>
void read_first(const std::string& file, std::int64_t n_records, OnRecord on_record) {
  std::int64_t n = 0;
  read_journal(file, [&](const LogEvent& event) {
    if (n++ < n_records) on_record(event);
  });
}

}  // namespace

std::string Bus::Impl::boot_id() {
  std::ifstream in("/proc/sys/kernel/random/boot_id");
  std::string id;
  std::getline(in, id);
  return id;
}

void Bus::Impl::open_journal() {
  const bool wanted = !journal_channels.empty() || !said.empty();
  if (options.journal.empty() || options.mode != Mode::kLive || journal || !wanted) return;
  const bool speaks = std::any_of(said.begin(), said.end(),
                                  [](const auto& channel) { return channel.second.sent; });
  {
    const std::lock_guard<std::mutex> lock(journal_mutex);
    std::string last_boot = boot_id();
    journal = std::make_unique<Journal>(options.journal, [&](const LogEvent& event) {
      if (event.channel != kJournalMark) return;
      const command_t mark = mark_from(event);
      if (mark.verb == kJournalOpened || mark.verb == kJournalCut) last_boot = mark.argument;
    });
    const JournalState& state = journal->state();
    const bool empty = state.n_records == 0;
    // What the kernel had survives a process; it need not survive the machine.
    const bool cut = state.cut_bytes > 0 || (state.existed && empty) || last_boot != boot_id();
    if (speaks) mark_journal(cut);
    n_to_recover = empty && !cut ? 0 : journal->state().n_records;
  }
  if (n_to_recover == 0) return;
  read_said();
  read_handled(false);
}

void Bus::Impl::hand_over(const std::string& channel, const Handler& handler,
                          const LogEvent& event) {
  if (passes_guard(channel, *handler.type, event.data.data(), event.data.size()))
    decode_safely(channel, handler.decode, event.data.data(), event.data.size());
}

// Numbers and revisions go on where they ended, whatever the clock says now.
void Bus::Impl::read_said() {
  if (said.empty()) return;
  recovering = true;
  const LcmType* tile_type = builtin_schema().find("fusion_slam.tile_t");
  read_first(options.journal, n_to_recover, [&](const LogEvent& event) {
    if (event.channel == kJournalMark) {
      const command_t mark = mark_from(event);
      if (mark.verb == kJournalCut) skip_lost_numbers();
      if (mark.verb == kJournalSaid) tell_said(mark);
    }
    const auto it = said.find(event.channel);
    if (it == said.end()) return;
    if (it->second.sent) {
      const std::lock_guard<std::mutex> lock(out_mutex);
      if (it->second.handler.type->continues_with_seq)
        outbox.skip_to(event.channel,
                       peek_seq(event.data.data(), event.data.size()).value_or(0) - 1);
      if (it->second.handler.type == tile_type) {
        const auto tile = bus_detail::decode<tile_t>(event.data.data(), event.data.size());
        outbox.sent_tile(event.channel, {tile.submap_id, tile.x, tile.y, tile.z}, tile.revision,
                         event.data);
        while (first_revision < tile.revision) first_revision += kRevisionStep;
      } else {
        outbox.sent(event.channel, event.data);
      }
    }
    hand_over(event.channel, it->second.handler, event);
  });
  recovering = false;
}

// A journal that was written anew begins with how far counting had come.
void Bus::Impl::tell_said(const command_t& mark) {
  const std::vector<std::int64_t> numbers = numbers_from_text(mark.argument);
  if (numbers.empty()) return;
  std::map<std::int64_t, std::int64_t> never;
  for (std::size_t i = 1; i + 1 < numbers.size(); i += 2) never[numbers[i + 1]] = numbers[i];
  const std::lock_guard<std::mutex> lock(out_mutex);
  outbox.was_given(mark.target, numbers.front(), never);
}

// None of those that may have been lost is given a second time: listeners know them.
void Bus::Impl::skip_lost_numbers() {
  const std::lock_guard<std::mutex> lock(out_mutex);
  for (const auto& [channel, what] : said)
    if (what.sent && what.handler.type->continues_with_seq)
      outbox.skip_to(channel, first_after_cut(outbox.next_seq(channel) - 1) - 1);
}

void Bus::Impl::mark_journal(bool cut) {
  command_t mark{};
  mark.utime = wall_us();
  mark.target = options.process;
  mark.verb = cut ? kJournalCut : kJournalOpened;
  mark.argument = boot_id();
  const auto bytes = bus_detail::encode(mark);
  if (!journal->append(mark.utime, kJournalMark, bytes.data(), bytes.size()))
    report("the journal " + options.journal + " can't be written: is the disk full?");
}

void Bus::Impl::read_handled(bool when_asked) {
  if (n_to_recover == 0) return;
  const std::int64_t begin_us = steady_us();
  std::map<std::string, std::size_t> by_name;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    for (std::size_t i = 0; i < inbox.channels().size(); ++i) by_name[inbox.channels()[i].name] = i;
  }
  recovering = true;
  struct Number {
    std::size_t channel;
    std::int64_t seq;
    std::int64_t utime_us;
  };
  std::vector<Number> numbers;
  std::int64_t n = 0;
  std::int64_t n_records = 0;
  read_first(options.journal, n_to_recover, [&](const LogEvent& event) {
    const JournalState at{n_records++, event.offset_bytes};
    if (event.channel == kJournalMark) {
      const command_t mark = mark_from(event);
      const auto told = by_name.find(mark.target);
      const auto wanted = journal_channels.find(mark.target);
      if (mark.verb == kJournalHeard && told != by_name.end() && wanted != journal_channels.end() &&
          wanted->second == when_asked)
        for (const std::int64_t seq : tell_heard(mark))
          numbers.push_back({told->second, seq, mark.utime});
      return;
    }
    const auto it = by_name.find(event.channel);
    const auto wanted = journal_channels.find(event.channel);
    if (it == by_name.end() || wanted == journal_channels.end() || wanted->second != when_asked)
      return;
    const Handler* handler = nullptr;
    {
      const std::lock_guard<std::mutex> lock(mutex);
      handler = &handlers[it->second];
    }
    hand_over(event.channel, *handler, event);
    ++n;
    if (was_heard(event.channel, event.data, at) && handler->type->continues_with_seq)
      numbers.push_back({it->second, peek_seq(event.data.data(), event.data.size()).value_or(0),
                         peek_utime(event.data.data(), event.data.size()).value_or(0)});
  });
  recovering = false;
  {  // at once: what is missing between them must not be asked for before the last is known
    const std::lock_guard<std::mutex> lock(mutex);
    for (const Number& number : numbers)
      inbox.was_handled(number.channel, number.seq, number.utime_us, steady_us());
  }
  if (n == 0) return;
  std::cerr << options.process << ": built up again from " << n << " messages of "
            << options.journal << " in " << (steady_us() - begin_us) / 1000 << " ms" << std::endl;
}

void Bus::Impl::write_to_journal(const InboxItem& item) {
  if (!journal) return;
  std::string channel;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    channel = inbox.channels()[item.channel].name;
  }
  if (journal_channels.count(channel) == 0) return;
  JournalState at;
  {
    const std::lock_guard<std::mutex> lock(journal_mutex);
    at = journal->newest();
  }
  append_to_journal(channel, item.bytes);
  was_heard(channel, item.bytes, at);
}

void Bus::Impl::write_said(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  const auto it = said.find(channel);
  if (it != said.end() && it->second.sent) append_to_journal(channel, bytes);
}

void Bus::Impl::append_to_journal(const std::string& channel,
                                  const std::vector<std::uint8_t>& bytes) {
  const std::lock_guard<std::mutex> lock(journal_mutex);
  if (renewing && journal) {
    renewal_failed |= !append_anew(channel, bytes);
    return;
  }
  if (!journal || journal->append(wall_us(), channel, bytes.data(), bytes.size())) return;
  report("the journal " + options.journal +
         " can't be written: is the disk full? A restart would lose " + channel + " from now on");
}

}  // namespace fusion_slam
