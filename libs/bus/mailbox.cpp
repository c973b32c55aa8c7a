#include "libs/bus/mailbox.hpp"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <iostream>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "libs/bus/transport.hpp"
#include "libs/schema/guard.hpp"
#include "libs/schema/schema.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kMostWaiting = 1000;
constexpr std::int64_t kReported = 10;

}  // namespace

struct Mailbox::Impl {
  explicit Impl(const std::string& url) : transport(url) {}

  struct Item {
    const Decode* decode = nullptr;
    std::vector<std::uint8_t> bytes;
  };

  void refuse(const std::string& why) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (++refused <= kReported) std::cerr << "refused: " << why << std::endl;
  }

  void decode_safely(const std::string& channel, const Decode& decode, const std::uint8_t* bytes,
                     std::size_t size) {
    try {
      decode(bytes, size);
    } catch (const bus_detail::Undecodable& error) {
      refuse("channel " + channel + ": " + error.what());
    }
  }

  Transport transport;
  mutable std::mutex mutex;
  std::condition_variable changed;
  std::deque<Item> waiting;
  std::deque<Decode> decoders;  // addresses stay
  std::int64_t refused = 0;
  std::int64_t dropped = 0;
  std::vector<std::shared_ptr<void>> tokens;  // last: destroyed first
};

Mailbox::Mailbox(const std::string& url) : impl_(std::make_unique<Impl>(url)) {}
Mailbox::~Mailbox() = default;

void Mailbox::add(const std::string& channel, std::int64_t fingerprint, Decode decode,
                  Filter filter, bool at_once) {
  const LcmType* type = builtin_schema().find(static_cast<std::uint64_t>(fingerprint));
  if (type == nullptr) throw std::logic_error("channel " + channel + ": unknown type");
  impl_->decoders.push_back(std::move(decode));
  const Decode* decoder = &impl_->decoders.back();
  impl_->tokens.push_back(impl_->transport.subscribe(
      channel, [impl = impl_.get(), type, decoder, filter = std::move(filter), at_once](
                   const std::string& name, const std::uint8_t* bytes, std::size_t size) {
        if (filter && (size = filter(bytes, size)) == 0)
          return impl->refuse("channel " + name + ": not signed with our key");
        if (const auto why = check(*type, bytes, size))
          return impl->refuse("channel " + name + ": " + *why);
        if (at_once) return impl->decode_safely(name, *decoder, bytes, size);
        const std::lock_guard<std::mutex> lock(impl->mutex);
        if (impl->waiting.size() >= kMostWaiting) {
          impl->waiting.pop_front();
          ++impl->dropped;
        }
        impl->waiting.push_back({decoder, {bytes, bytes + size}});
        impl->changed.notify_all();
      }));
}

void Mailbox::publish_bytes(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  impl_->transport.publish(channel, bytes);
}

std::size_t Mailbox::handle(int timeout_ms) {
  std::deque<Impl::Item> items;
  {
    std::unique_lock<std::mutex> lock(impl_->mutex);
    impl_->changed.wait_for(lock, std::chrono::milliseconds(timeout_ms),
                            [this] { return !impl_->waiting.empty(); });
    items.swap(impl_->waiting);
  }
  for (const Impl::Item& item : items)
    impl_->decode_safely("", *item.decode, item.bytes.data(), item.bytes.size());
  return items.size();
}

std::int64_t Mailbox::refused() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->refused;
}

std::int64_t Mailbox::dropped() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->dropped;
}

}  // namespace fusion_slam
