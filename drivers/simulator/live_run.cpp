#include "drivers/simulator/live_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "libs/clock/clock.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kFramesAhead = 8;  // rendered and waiting, at most
constexpr double kCostMemory = 0.8;      // share of the old estimate that a new frame leaves

}  // namespace

LiveRun::LiveRun(Simulation& simulation, int threads, Publish publish)
    : simulation_(simulation),
      threads_(std::max(1, threads)),
      publish_(std::move(publish)),
      half_period_us_(std::llround(0.5e6 / simulation.camera().rate_hz)) {}

std::int64_t LiveRun::now_us() const { return epoch_us_ + steady_us() - steady_start_us_; }

bool LiveRun::wait_until(std::int64_t utime_us) {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!stopping_) {
    const std::int64_t left_us = utime_us - now_us();
    if (left_us <= 0) return true;
    changed_.wait_for(lock, std::chrono::microseconds(left_us));
  }
  return false;
}

bool LiveRun::in_time(std::size_t k, std::int64_t now_us) const {
  return static_cast<double>(now_us) + cost_us_ <=
         static_cast<double>(frames_[k].ready_us + half_period_us_);
}

void LiveRun::render_frames() {
  for (;;) {
    std::size_t k = 0;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [&] { return stopping_ || next_ < published_ + kFramesAhead; });
      while (!stopping_ && next_ < frames_.size() && !in_time(next_, now_us())) {
        simulation_.skip_frame(frames_[next_]);
        ready_[next_++] = std::nullopt;
        cost_us_ *= kCostMemory;  // so that a single slow frame does not end the film
      }
      changed_.notify_all();
      if (stopping_ || next_ >= frames_.size()) return;
      k = next_++;
    }
    const std::int64_t begun_us = steady_us();
    Bytes bytes = simulation_.message(frames_[k]);
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto took_us = static_cast<double>(steady_us() - begun_us);
    cost_us_ = kCostMemory * cost_us_ + (1.0 - kCostMemory) * took_us;
    ready_[k] = std::move(bytes);
    changed_.notify_all();
  }
}

void LiveRun::publish_frames() {
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    if (!wait_until(frames_[k].ready_us)) return;
    std::optional<Bytes> bytes;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      const auto known = [&] { return stopping_ || ready_.count(k) != 0; };
      const std::int64_t patience_us = frames_[k].ready_us + half_period_us_ - now_us();
      changed_.wait_for(lock, std::chrono::microseconds(std::max<std::int64_t>(0, patience_us)),
                        known);
      if (stopping_) return;
      if (const auto it = ready_.find(k); it != ready_.end()) bytes = std::move(it->second);
      ready_.erase(ready_.begin(), ready_.upper_bound(k));
      published_ = k + 1;
      ++(bytes ? progress_.frames_published : progress_.frames_dropped);
      changed_.notify_all();
    }
    if (bytes) publish_(name_of(Channel::kCamera), *bytes);
  }
}

void LiveRun::publish_others() {
  std::vector<Due> others;
  for (const Due& due : simulation_.schedule())
    if (due.channel != Channel::kCamera) others.push_back(due);
  std::stable_sort(others.begin(), others.end(),
                   [](const Due& a, const Due& b) { return a.ready_us < b.ready_us; });
  for (const Due& due : others) {
    if (!wait_until(due.ready_us)) return;
    publish_(name_of(due.channel), simulation_.message(due));
  }
}

void LiveRun::run() {
  simulation_.practise();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    epoch_us_ = wall_us();
    steady_start_us_ = steady_us();
    simulation_.start_at(epoch_us_);
    for (const Due& due : simulation_.schedule())
      if (due.channel == Channel::kCamera) frames_.push_back(due);
    progress_.started = true;
  }
  std::vector<std::thread> workers;
  workers.reserve(std::size_t(std::max(0, threads_)));
  for (int i = 0; i < threads_; ++i) workers.emplace_back([this] { render_frames(); });
  std::thread camera([this] { publish_frames(); });
  publish_others();
  camera.join();
  for (std::thread& worker : workers) worker.join();
}

void LiveRun::stop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  stopping_ = true;
  simulation_.cancel();
  changed_.notify_all();
}

LiveRun::Progress LiveRun::progress() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Progress progress = progress_;
  if (progress.started)
    progress.time_s =
        std::min(simulation_.seconds(), 1e-6 * static_cast<double>(now_us() - epoch_us_));
  return progress;
}

}  // namespace fusion_slam
