// A place for one thing: what comes next replaces what nobody has taken. For who would rather be up
// to date than complete. Any threads.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

namespace fusion_slam {

template <class T>
class Latest {
 public:
  void put(T value) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (value_) ++replaced_;
    value_ = std::move(value);
    changed_.notify_one();
  }
  // Waits for something. Nothing after close().
  std::optional<T> take() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return value_.has_value() || closed_; });
    if (closed_) return std::nullopt;
    return std::exchange(value_, std::nullopt);
  }
  void close() {
    const std::lock_guard<std::mutex> lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }
  std::int64_t replaced() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return replaced_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<T> value_;
  std::int64_t replaced_ = 0;
  bool closed_ = false;
};

}  // namespace fusion_slam
