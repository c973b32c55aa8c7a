// The Bus's journal: a live process that is killed and started again first handles again what it
// had handled.
#include <iostream>

#include "libs/bus/bus_internal.hpp"
#include "libs/clock/clock.hpp"
#include "libs/schema/guard.hpp"

namespace fusion_slam {

void Bus::Impl::open_journal() {
  if (options.journal.empty() || options.mode != Mode::kLive || journal || journal_channels.empty())
    return;
  journal = std::make_unique<Journal>(options.journal);
  if (journal->state().n_records == 0) return;
  std::map<std::string, std::size_t> by_name;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    for (std::size_t i = 0; i < inbox.channels().size(); ++i) by_name[inbox.channels()[i].name] = i;
  }
  recovering = true;
  std::int64_t n = 0;
  read_journal(options.journal, [&](const LogEvent& event) {
    const auto it = by_name.find(event.channel);
    if (it == by_name.end()) return;
    const Handler* handler = nullptr;
    {
      const std::lock_guard<std::mutex> lock(mutex);
      handler = &handlers[it->second];
    }
    const std::uint8_t* bytes = event.data.data();
    if (!passes_guard(event.channel, *handler->type, bytes, event.data.size())) return;
    decode_safely(event.channel, handler->decode, bytes, event.data.size());
    ++n;
    const std::lock_guard<std::mutex> lock(mutex);
    if (handler->type->continues_with_seq)
      inbox.was_handled(it->second, peek_seq(bytes, event.data.size()).value_or(0),
                        peek_utime(bytes, event.data.size()).value_or(0));
  });
  recovering = false;
  std::cerr << options.process << ": built up again from " << n << " messages of "
            << options.journal << std::endl;
}

void Bus::Impl::write_to_journal(const InboxItem& item) {
  if (!journal) return;
  std::string channel;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    channel = inbox.channels()[item.channel].name;
  }
  if (journal_channels.count(channel) == 0) return;
  if (!journal->append(wall_us(), channel, item.bytes.data(), item.bytes.size()))
    report("the journal " + options.journal +
           " can't be written: is the disk full? A restart would lose " + channel + " from now on");
}

}  // namespace fusion_slam
