#include "libs/bus/transport.hpp"

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <list>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include <lcm/lcm.h>

namespace fusion_slam {
namespace {

constexpr int kPoll_ms = 20;

// Lives as long as the transport: LCM may be about to call it while its owner goes away.
struct Subscription {
  Transport::Receive receive;  // empty once the owner is gone
  std::recursive_mutex* mutex = nullptr;
};

// LCM's C interface: the C++ header's member-function callbacks trip GCC 12's
// UndefinedBehaviorSanitizer.
void deliver(const lcm_recv_buf_t* buffer, const char* channel, void* user) {
  const auto* subscription = static_cast<const Subscription*>(user);
  const std::lock_guard<std::recursive_mutex> lock(*subscription->mutex);
  if (subscription->receive)
    subscription->receive(channel, static_cast<const std::uint8_t*>(buffer->data),
                          buffer->data_size);
}

}  // namespace

struct Transport::Impl {
  explicit Impl(const std::string& complete) : url(complete), lcm(lcm_create(complete.c_str())) {}
  ~Impl() {
    if (lcm != nullptr) lcm_destroy(lcm);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void loop() {
    while (!stopping) {
      const int result = lcm_handle_timeout(lcm, kPoll_ms);
      if (result < 0) {
        ended = true;
        std::this_thread::sleep_for(std::chrono::milliseconds(kPoll_ms));
      }
      const std::lock_guard<std::recursive_mutex> lock(mutex);
      for (const auto& callback : idle) (*callback)();
    }
  }

  std::string url;
  lcm_t* lcm;
  std::atomic<bool> stopping{false};
  std::atomic<bool> ended{false};
  std::recursive_mutex mutex;  // of the lists, and against owners that leave while a callback runs
  std::list<std::shared_ptr<std::function<void()>>> idle;
  std::list<Subscription> subscriptions;
  std::once_flag started;
  std::thread thread;
};

std::string complete_url(const std::string& url) {
  std::string complete = url;
  if (complete.empty()) {
    const char* environment = std::getenv("LCM_DEFAULT_URL");
    complete = environment != nullptr ? environment : "udpm://239.255.76.67:7667?ttl=0";
  }
  if (complete.rfind("udpm://", 0) == 0 && complete.find("recv_buf_size") == std::string::npos)
    complete += (complete.find('?') == std::string::npos ? "?" : "&") +
                std::string("recv_buf_size=4194304");
  return complete;
}

Transport::Transport(const std::string& url) : impl_(std::make_unique<Impl>(complete_url(url))) {
  if (impl_->lcm == nullptr)
    throw std::runtime_error("cannot open the LCM network " + impl_->url +
                             ": run `fusion-slam doctor`, it says what is wrong and what mends it");
  if (impl_->url.rfind("file://", 0) != 0) start();
}

void Transport::start() {
  std::call_once(impl_->started,
                 [this] { impl_->thread = std::thread([this] { impl_->loop(); }); });
}

Transport::~Transport() {
  impl_->stopping = true;
  if (impl_->thread.joinable()) impl_->thread.join();
}

std::shared_ptr<void> Transport::subscribe(const std::string& channel, Receive receive) {
  Subscription* mine = nullptr;
  {
    const std::lock_guard<std::recursive_mutex> lock(impl_->mutex);
    impl_->subscriptions.push_back({std::move(receive), &impl_->mutex});
    mine = &impl_->subscriptions.back();
  }
  // No limit on LCM's own queue: the reader's thread empties it at once.
  lcm_subscription_set_queue_capacity(lcm_subscribe(impl_->lcm, channel.c_str(), &deliver, mine),
                                      0);
  return {mine, [impl = impl_.get()](Subscription* gone) {
            const std::lock_guard<std::recursive_mutex> lock(impl->mutex);
            gone->receive = nullptr;
          }};
}

std::shared_ptr<void> Transport::on_idle(std::function<void()> callback) {
  const std::lock_guard<std::recursive_mutex> lock(impl_->mutex);
  auto entry = std::make_shared<std::function<void()>>(std::move(callback));
  impl_->idle.push_back(entry);
  return {entry.get(), [impl = impl_.get(), entry](void*) {
            const std::lock_guard<std::recursive_mutex> inner(impl->mutex);
            impl->idle.remove(entry);
          }};
}

void Transport::publish(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  lcm_publish(impl_->lcm, channel.c_str(), bytes.data(), static_cast<unsigned>(bytes.size()));
}

const std::string& Transport::url() const { return impl_->url; }
bool Transport::at_end() const { return impl_->ended; }

}  // namespace fusion_slam
