// The Bus's journal written anew with what a restart would still use, so that it doesn't grow with
// time.
#include <algorithm>

#include "libs/bus/bus_internal.hpp"
#include "libs/bus/journal_mark.hpp"
#include "libs/clock/clock.hpp"
#include "libs/schema/guard.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kSmall_bytes = 64 << 20;     // below nothing is worth writing anew
constexpr std::int64_t kForgotten_us = 60'000'000;  // what is missing for longer isn't coming
constexpr std::size_t kMostMissing = 1000;
constexpr std::int64_t kFarthestMissing = 10'000;

std::int64_t seq_of(const std::vector<std::uint8_t>& bytes) {
  return peek_seq(bytes.data(), bytes.size()).value_or(0);
}

}  // namespace

// From the thread that handles.
bool Bus::Impl::journal_is_large() {
  if (!needs || recovering) return false;
  const std::lock_guard<std::mutex> lock(journal_mutex);
  if (!journal) return false;
  journal->settle();
  if (journal->is_renewed()) return false;
  const bool to_be_read = n_to_recover > 0 && !asked_to_recover &&
                          std::any_of(journal_channels.begin(), journal_channels.end(),
                                      [](const auto& channel) { return channel.second; });
  if (to_be_read) return false;
  if (journal_limit_bytes ==
      0)  // what an earlier process kept isn't known: all of it may be needed
    journal_limit_bytes = kSmall_bytes;
  return journal->state().whole_bytes >= journal_limit_bytes;
}

bool Bus::Impl::renew_journal() {
  if (!needs) return false;
  const std::lock_guard<std::mutex> nothing_is_said(out_mutex);
  bool ok = false;
  {
    const std::lock_guard<std::mutex> lock(journal_mutex);
    if (!journal || !journal->begin_anew()) return false;
    ok = keep_said_and_heard();
    renewing = ok;
    renewal_failed = !ok;
  }
  if (ok && needs->note_state) needs->note_state();
  const std::lock_guard<std::mutex> lock(journal_mutex);
  renewing = false;
  ok = !renewal_failed;
  const std::int64_t kept_bytes = journal->newest().whole_bytes;
  if (ok)
    ok = journal->finish_anew();
  else
    journal->abandon_anew();
  // When there was no room: not again at once.
  journal_limit_bytes =
      std::max(kSmall_bytes, 2 * std::max(kept_bytes, ok ? 0 : journal_limit_bytes));
  return ok;
}

bool Bus::Impl::append_anew(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  return journal->append_anew(wall_us(), channel, bytes.data(), bytes.size());
}

bool Bus::Impl::mark_anew(const char* verb, const std::string& channel, std::int64_t utime_us,
                          const std::vector<std::int64_t>& numbers) {
  command_t message{};
  message.utime = utime_us;
  message.target = channel;
  message.verb = verb;
  message.argument = numbers_to_text(numbers);
  return append_anew(kJournalMark, bus_detail::encode(message));
}

// out_mutex and journal_mutex held.
bool Bus::Impl::keep_said_and_heard() {
  command_t opened{};
  opened.utime = wall_us();
  opened.target = options.process;
  opened.verb = kJournalOpened;
  opened.argument = boot_id();
  if (!append_anew(kJournalMark, bus_detail::encode(opened))) return false;
  for (const auto& [channel, what] : said) {
    if (!what.sent) continue;
    const Outbox::Recent& recent = outbox.recent(channel);
    const std::int64_t last =
        recent.empty() ? outbox.next_seq(channel) - 1 : recent.front().first - 1;
    std::vector<std::int64_t> numbers = {last};
    for (const auto& [to, from] : outbox.never_given(channel, last)) {
      numbers.push_back(from);
      numbers.push_back(to);
    }
    if (!mark_anew(kJournalSaid, channel, 0, numbers)) return false;
    for (const auto& [seq, bytes] : recent)
      if (!append_anew(channel, bytes)) return false;
  }
  for (const bool models : {true, false})  // first what the rest is understood with
    for (auto& [channel, what] : heard)
      if ((needs->first_of.count(channel) != 0) == models && !keep_heard(channel, &what))
        return false;
  return true;
}

// out_mutex and journal_mutex held.
bool Bus::Impl::keep_heard(const std::string& channel, Heard* there) {
  Heard& what = *there;
  what.sequence.give_up(steady_us(), kForgotten_us);
  std::vector<std::int64_t> numbers = {what.sequence.highest()};
  for (const std::int64_t seq : what.sequence.missing(steady_us(), 0, kMostMissing))
    numbers.push_back(seq);
  if (!mark_anew(kJournalHeard, channel, what.newest_utime_us, numbers)) return false;
  if (!what.first.empty() && !append_anew(channel, what.first)) return false;
  const std::set<std::int64_t> wanted =
      needs->numbers && what.first.empty() ? needs->numbers(channel) : std::set<std::int64_t>{};
  auto before = std::exchange(what.at, {});
  for (const std::int64_t seq : wanted) {
    const auto it = before.find(seq);
    if (it == before.end()) continue;
    const auto record = journal->record_at(it->second.first, it->second.second);
    if (!record || record->channel != channel || seq_of(record->data) != seq) continue;
    what.at[seq] = {journal->newest().whole_bytes, journal->newest().n_records};
    if (!append_anew(channel, record->data)) return false;
  }
  return true;
}

bool Bus::Impl::was_heard(const std::string& channel, const std::vector<std::uint8_t>& bytes,
                          const JournalState& at) {
  if (!needs) return true;
  const std::lock_guard<std::mutex> lock(journal_mutex);
  Heard& what = heard[channel];
  if (needs->first_of.count(channel) != 0 && what.first.empty()) what.first = bytes;
  const std::int64_t seq = seq_of(bytes);
  if (seq <= 0) return true;
  const std::int64_t utime_us = peek_utime(bytes.data(), bytes.size()).value_or(0);
  if (what.first.empty()) what.at[seq] = {at.whole_bytes, at.n_records};
  if (seq <= what.told_upto && utime_us <= what.told_utime_us && what.told_missing.count(seq) == 0)
    return false;
  what.newest_utime_us = std::max(what.newest_utime_us, utime_us);
  if (recovering)
    what.sequence.was_handled(seq, utime_us, steady_us());
  else
    what.sequence.see(seq, utime_us, steady_us());
  return true;
}

// Returns the numbers from which both sides' bookkeeping follows.
std::vector<std::int64_t> Bus::Impl::tell_heard(const command_t& mark) {
  const std::vector<std::int64_t> numbers = numbers_from_text(mark.argument);
  if (!needs || numbers.empty() || numbers.front() <= 0) return {};
  const std::lock_guard<std::mutex> lock(journal_mutex);
  Heard& what = heard[mark.target];
  what.told_upto = numbers.front();
  what.told_utime_us = what.newest_utime_us = mark.utime;
  for (std::size_t i = 1; i < numbers.size(); ++i)
    if (numbers[i] > what.told_upto - kFarthestMissing) what.told_missing.insert(numbers[i]);
  std::int64_t first = what.told_missing.empty() ? what.told_upto : *what.told_missing.begin() - 1;
  std::vector<std::int64_t> handled;
  for (std::int64_t seq = std::max<std::int64_t>(first, 1); seq <= what.told_upto; ++seq)
    if (what.told_missing.count(seq) == 0) handled.push_back(seq);
  for (const std::int64_t seq : handled) what.sequence.was_handled(seq, mark.utime, steady_us());
  return handled;
}

}  // namespace fusion_slam
