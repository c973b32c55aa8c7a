#include "drivers/simulator/recording.hpp"

#include <algorithm>
#include <deque>
#include <future>
#include <utility>

#include "libs/eventlog/writer.hpp"

namespace fusion_slam {
namespace {

// Frames in order, rendered ahead by several threads.
class FrameQueue {
 public:
  FrameQueue(const Simulation& simulation, int threads) : simulation_(simulation) {
    std::copy_if(simulation.schedule().begin(), simulation.schedule().end(),
                 std::back_inserter(frames_),
                 [](const Due& due) { return due.channel == Channel::kCamera; });
    for (int i = 0; i < std::max(1, threads); ++i) start_next();
  }
  // Nobody may wait for frames that are never begun.
  ~FrameQueue() { simulation_.cancel(); }
  FrameQueue(const FrameQueue&) = delete;
  FrameQueue& operator=(const FrameQueue&) = delete;

  Bytes pop() {
    Bytes bytes = ahead_.front().get();
    ahead_.pop_front();
    start_next();
    return bytes;
  }
  std::int64_t size() const { return static_cast<std::int64_t>(frames_.size()); }

 private:
  void start_next() {
    if (next_ == frames_.size()) return;
    ahead_.push_back(std::async(std::launch::async,
                                [this, due = frames_[next_]] { return simulation_.message(due); }));
    ++next_;
  }
  const Simulation& simulation_;
  std::vector<Due> frames_;
  std::size_t next_ = 0;
  std::deque<std::future<Bytes>> ahead_;  // last: its destructor waits for what uses the others
};

}  // namespace

RecordingSummary write_recording(const Simulation& simulation, int threads,
                                 const std::filesystem::path& path,
                                 const std::function<void(std::int64_t, std::int64_t)>& progress) {
  LogWriter log(path);
  FrameQueue queue(simulation, threads);
  std::int64_t frames = 0;
  for (const Due& due : simulation.schedule()) {
    const bool is_frame = due.channel == Channel::kCamera;
    log.write(due.utime_us, name_of(due.channel), is_frame ? queue.pop() : simulation.message(due));
    if (is_frame && progress) progress(++frames, queue.size());
  }
  log.close();
  return {log.n_events(), queue.size(), log.size_bytes(), simulation.seconds(), simulation.lap_s()};
}

}  // namespace fusion_slam
